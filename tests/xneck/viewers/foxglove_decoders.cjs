// The curves of a layout, {label: [[time, s], [value]]}, from a data set, by the packages with which Foxglove reads MCAP.
const fs = require("fs");
const { McapIndexedReader } = require("@mcap/core");
const { FileHandleReadable } = require("@mcap/nodejs");
const { loadDecompressHandlers } = require("@mcap/support");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

async function main(dataset, layoutFile) {
  const layout = JSON.parse(fs.readFileSync(layoutFile, "utf8"));
  const paths = Object.values(layout.configById).flatMap((plot) => plot.paths);
  const curves = Object.fromEntries(paths.map((path) => [path.label, [[], []]]));
  const file = await fs.promises.open(dataset);
  const reader = await McapIndexedReader.Initialize({
    readable: new FileHandleReadable(file),
    decompressHandlers: await loadDecompressHandlers(),
  });
  const decoders = new Map();
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    if (channel.messageEncoding !== "cdr" || schema.encoding !== "ros2msg") throw new Error(`${channel.topic}: not ROS 2`);
    decoders.set(channel.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  }
  for await (const message of reader.readMessages()) {
    const topic = reader.channelsById.get(message.channelId).topic;
    const decoded = decoders.get(message.channelId).readMessage(message.data);
    for (const path of paths) {
      const [, of, place] = /^(.*)\.position\[(\d+)\]$/.exec(path.value);
      if (of !== topic) continue;
      curves[path.label][0].push(Number(message.logTime) / 1e9);
      curves[path.label][1].push(decoded.position[Number(place)]);
    }
  }
  await file.close();
  process.stdout.write(JSON.stringify(curves));
}

main(process.argv[2], process.argv[3]);
