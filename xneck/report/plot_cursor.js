// Figures of a page: a click on one zooms into it, another click or Escape shows it whole again; over figures of the recording's time
// a cursor stands at the same moment in all of them, and the video shows the arm at that moment, near the figure where its own place
// is out of sight; while it plays, the cursor runs along. Without this script the page is whole: it only adds.
(() => {
  const plots = [...document.querySelectorAll('svg.plot')];
  const whole = new Map(plots.map(plot => [plot, plot.getAttribute('viewBox')]));
  // left, right, top, bottom of the axes in the figure's units, and the times at left and right, s
  const timed = plots.filter(plot => plot.dataset.time).map(plot => {
    const [left, right, top, bottom, begin, end] = plot.dataset.time.split(' ').map(Number);
    const line = plot.appendChild(document.createElementNS(plot.namespaceURI, 'path'));
    line.setAttribute('class', 'cursor');
    return { plot, line, left, right, top, bottom, begin, end };
  });
  const shown = document.body.appendChild(document.createElement('output'));
  shown.className = 'cursor';
  shown.hidden = true;

  // the video, the times of its frames on its own clock and on the log's, s, and the moment to show once it has found the one before
  const video = document.querySelector('.film video');
  const [videoTimes, logTimes] = ['videoTimes', 'logTimes'].map(name => (video?.dataset[name] || '').split(' ').map(Number));
  let wanted = null;

  const place = (plot, event) =>
    new DOMPoint(event.clientX, event.clientY).matrixTransform(plot.getScreenCTM().inverse());

  function show(time) {
    for (const { line, left, right, top, bottom, begin, end } of timed) {
      const x = left + (right - left) * (time - begin) / (end - begin);
      line.setAttribute('d', x < left || x > right ? '' : `M${x} ${top}V${bottom}`);
    }
    shown.textContent = `${time.toFixed(3)} s`;
    shown.hidden = false;
  }

  function hide() {
    for (const { line } of timed) line.setAttribute('d', '');
    shown.hidden = true;
  }

  // number of the last of the increasing times that is not later, or of the first one
  function frameAt(times, time) {
    let low = 0, high = times.length;
    while (high - low > 1) {
      const middle = low + high >> 1;
      if (times[middle] > time) high = middle; else low = middle;
    }
    return low;
  }

  function seek(time) {
    const frame = frameAt(logTimes, time);
    // between this frame and the next, so that rounding does not show the one before
    const later = Math.min((videoTimes[frame + 1] ?? videoTimes[frame]) - videoTimes[frame], 0.02);
    wanted = videoTimes[frame] + later / 2;
    if (!video.seeking) catchUp();
  }

  function catchUp() {
    if (wanted === null) return;
    video.currentTime = wanted;
    wanted = null;
  }

  // the video near the pointer where its place in the page is out of sight: on the side that the pointer is not on
  function dock(event) {
    const { top, bottom } = video.parentElement.getBoundingClientRect(), away = bottom < 80 || top > innerHeight - 80;
    video.classList.toggle('docked', away);
    video.controls = !away;
    video.classList.toggle('left', event.clientX > innerWidth / 2);
    video.classList.toggle('high', event.clientY > innerHeight / 2);
  }

  function undock() {
    if (!video) return;
    video.classList.remove('docked', 'left', 'high');
    video.controls = true;
  }

  for (const { plot, left, right, begin, end } of timed) {
    plot.addEventListener('pointermove', event => {
      const share = (place(plot, event).x - left) / (right - left), time = begin + share * (end - begin);
      if (share < 0 || share > 1) { hide(); undock(); return; }
      show(time);
      if (video) { video.pause(); dock(event); seek(time); }
    });
    plot.addEventListener('pointerleave', () => { hide(); undock(); });
  }
  if (video) {
    video.addEventListener('seeked', catchUp);
    const follow = () => { if (!video.paused) show(logTimes[frameAt(videoTimes, video.currentTime + 1e-3)]); };
    video.addEventListener('timeupdate', follow);
    if (video.requestVideoFrameCallback) {
      const again = () => { follow(); video.requestVideoFrameCallback(again); };
      video.requestVideoFrameCallback(again);
    }
  }

  function makeWhole() {
    for (const [plot, box] of whole) {
      plot.setAttribute('viewBox', box);
      plot.classList.remove('zoomed');
    }
  }

  for (const plot of plots) {
    plot.classList.add('zooms');
    plot.addEventListener('click', event => {
      const zoomed = plot.classList.contains('zoomed'), at = place(plot, event);
      makeWhole();
      if (zoomed) return;
      const [, , width, height] = whole.get(plot).split(/\s+/).map(Number), w = width / 3, h = height / 3;
      const x = Math.min(Math.max(at.x - w / 2, 0), width - w), y = Math.min(Math.max(at.y - h / 2, 0), height - h);
      plot.setAttribute('viewBox', `${x} ${y} ${w} ${h}`);
      plot.classList.add('zoomed');
    });
  }
  addEventListener('keydown', event => { if (event.key === 'Escape') makeWhole(); });
  addEventListener('beforeprint', () => { makeWhole(); hide(); undock(); });
})();
