// What uPlot does not draw itself: curves in typed arrays that end at NaN, and marks.

/** Return the path of a series: in every column of pixels its least and largest, and nothing where it is NaN. */
export function segments(chart, index, first, last) {
  const x = chart.data[0], y = chart.data[index], path = new Path2D();
  const {left, top, width, height} = chart.bbox, {x: across, y: up} = chart.scales;
  const perX = width / (across.max - across.min), perY = height / (up.max - up.min);
  let down = false, pixel = NaN, low = NaN, high = NaN, end = NaN;
  const finish = () => {
    if (high > low) { path.lineTo(pixel, low); path.lineTo(pixel, high); path.lineTo(pixel, end); }
  };
  for (let k = first; k <= last; k += 1) {
    const value = y[k];
    if (Number.isNaN(value)) {
      finish();
      down = false;
      low = high = NaN;
      continue;
    }
    const at = Math.round(left + perX * (x[k] - across.min)), place = top + perY * (up.max - value);
    if (down && at === pixel) {
      low = Math.min(low, place);
      high = Math.max(high, place);
    } else {
      finish();
      if (down) path.lineTo(at, place); else path.moveTo(at, place);
      [down, pixel, low, high] = [true, at, place, place];
    }
    end = place;
  }
  finish();
  return {stroke: path, fill: null, clip: null, band: null, gaps: [], flags: 1};
}

/** Draw under the curves: spans {start, end} of time, instants {at}, or levels {value}; lines where a dash is given. */
export function shade(chart, marks, colour, dash) {
  const {left, top, width, height} = chart.bbox, pen = chart.ctx;
  pen.save();
  pen.beginPath();
  pen.rect(left, top, width, height);
  pen.clip();
  pen.fillStyle = pen.strokeStyle = colour;
  pen.lineWidth = 1.5;
  pen.setLineDash(dash ?? []);
  for (const mark of marks) {
    if ("value" in mark) {
      line(pen, left, chart.valToPos(mark.value, "y", true), width, 0);
    } else if ("at" in mark) {
      line(pen, chart.valToPos(mark.at, "x", true), top, 0, height);
    } else {
      const [start, end] = [mark.start, mark.end].map((time) => chart.valToPos(time, "x", true));
      pen.fillRect(start, top, Math.max(1, end - start), height);
    }
  }
  pen.restore();
}

function line(pen, x, y, right, below) {
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(x + right, y + below);
  pen.stroke();
}
