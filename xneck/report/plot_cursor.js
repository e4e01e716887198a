// Figures of a page: a click on one zooms into it, another click or Escape shows it whole again; over figures of the recording's time
// a cursor stands at the same moment in all of them. Without this script the page is whole: it only adds.
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

  for (const { plot, left, right, begin, end } of timed) {
    plot.addEventListener('pointermove', event => {
      const share = (place(plot, event).x - left) / (right - left);
      if (share >= 0 && share <= 1) show(begin + share * (end - begin)); else hide();
    });
    plot.addEventListener('pointerleave', hide);
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
  addEventListener('beforeprint', () => { makeWhole(); hide(); });
})();
