// Charts that the page has drawn come alive: they are redrawn, read off and zoomed.
const WIDE = 2000, HIGH = 1000;

const text = (tag, words, style) => {
  const made = document.createElement(tag);
  made.textContent = words;
  if (style) made.className = style;
  return made;
};
const svg = (tag, attributes) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
};
const ends = (element, name) => element.getAttribute(name).split(" ").map(Number);
const embedded = (name) => {
  const held = document.getElementById(name);
  return held ? JSON.parse(held.textContent) : null;
};

const ticks = (low, high) => {
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  const decimals = Math.min(12, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
  const largest = Math.max(...found.map(Math.abs));
  const plain = largest >= 1e-4 && largest < 1e6;
  return found.map((v) => [v, plain ? v.toFixed(decimals) : String(Number(v.toPrecision(4)))]);
};

// A line has a style, words, times and values; where it has low and high, a band is drawn with it.
const bounds = (lines, from, to) => {
  let low = Infinity, high = -Infinity;
  lines.forEach((line) => [line.values, line.low, line.high].forEach((values) => {
    if (values) values.forEach((v, i) => {
      if (v === null || line.time[i] < from || line.time[i] > to) return;
      low = Math.min(low, v); high = Math.max(high, v);
    });
  }));
  return [low, high];
};

const pathOf = (line, values, from, to, x, y) => {
  const inside = line.time.map((t) => t >= from && t <= to);
  let d = "", pen = "M";
  line.time.forEach((t, i) => {
    const near = inside[i] || inside[i - 1] || inside[i + 1];
    const v = values[i];
    if (!near || v === null) { pen = "M"; return; }
    d += pen + x(t).toFixed(1) + " " + y(v).toFixed(1);
    pen = "L";
  });
  return d || "M0 0";
};

const bandOf = (line, x, y) => {
  const known = line.time.map((t, i) => [t, line.low[i], line.high[i]])
    .filter(([, low, high]) => low !== null && high !== null);
  const point = (t, v) => `${x(t).toFixed(1)} ${y(v).toFixed(1)}`;
  return "M" + [...known.map(([t, low]) => point(t, low)),
    ...known.reverse().map(([t, , high]) => point(t, high))].join("L") + "Z";
};

const draw = (chart, lines, from, to) => {
  const area = chart.querySelector(".area");
  let [low, high] = bounds(lines, from, to);
  if (!(high >= low)) return;
  const margin = 0.05 * (high - low) || 0.5 * Math.abs(high) || 0.5;
  low -= margin; high += margin;
  const x = (t) => WIDE * (t - from) / (to - from), y = (v) => HIGH * (high - v) / (high - low);
  area.querySelectorAll(".line, .band").forEach((old) => old.remove());
  const above = area.querySelector(".chosen");
  const add = (style, d) => area.insertBefore(svg("path", { class: style, d }), above);
  lines.filter((line) => line.low).forEach((line) => add("band " + line.style, bandOf(line, x, y)));
  lines.forEach((line) => add("line " + line.style, pathOf(line, line.values, from, to, x, y)));
  area.querySelectorAll(".window").forEach((window) => {
    const [start, end] = ends(window, "data-x");
    window.setAttribute("x", x(start));
    window.setAttribute("width", Math.max(6, x(end) - x(start)));
  });
  const across = ticks(low, high), along = ticks(from, to);
  area.querySelector(".grid").setAttribute("d",
    along.map(([t]) => `M${x(t)} 0V${HIGH}`).join("") + across.map(([v]) => `M0 ${y(v)}H${WIDE}`).join(""));
  const label = (style, place, words) => {
    const made = svg("text", { class: style, ...place });
    made.textContent = words;
    return made;
  };
  chart.querySelector(".ticks").replaceChildren(
    ...across.map(([v, words]) => label("y-tick", { x: -8, dy: 4, y: y(v) / HIGH * 100 + "%" }, words)),
    ...(chart.classList.contains("bare") ? [] : along.map(([t, words]) =>
      label("x-tick", { x: x(t) / WIDE * 100 + "%", y: "100%", dy: 17 }, words))));
};

// The row whose time is nearest.
const nearest = (time, t) => {
  let row = 0, last = time.length - 1;
  while (last - row > 1) {
    const middle = (row + last) >> 1;
    if (time[middle] <= t) row = middle; else last = middle;
  }
  return Math.abs(time[last] - t) < Math.abs(time[row] - t) ? last : row;
};

// Lets the charts of a panel be read and zoomed together; the read-out tells of the `read` lines.
const enliven = (panel) => {
  const charts = [...panel.querySelectorAll(".chart")];
  let shown = null, view = null, started = null;
  const readOut = text("p", "", "read-out");
  const hint = "Point at the curves to read them; drag to zoom, double-click to see all.";
  readOut.textContent = hint;
  charts[charts.length - 1].after(readOut);
  const cursors = charts.map((chart) => {
    const cursor = svg("path", { class: "cursor", d: "", visibility: "hidden" });
    const chosen = svg("rect", { class: "chosen", y: 0, height: HIGH, visibility: "hidden" });
    chart.querySelector(".area").append(chosen, cursor);
    return [cursor, chosen];
  });
  const show = (from, to) => {
    view = [from, to];
    charts.forEach((chart, k) => draw(chart, shown.charts[k], from, to));
  };
  const share = (event, plot) => {
    const box = plot.getBoundingClientRect();
    return Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
  };
  const read = (at) => {
    const first = shown.read[0].time;
    const t = first[nearest(first, view[0] + at * (view[1] - view[0]))];
    const told = shown.read.map((line) => [line.words, line.values[nearest(line.time, t)]])
      .filter(([, value]) => value !== null)
      .map(([words, value]) => `${words} ${Number(value.toPrecision(4))}`);
    readOut.textContent = `${Number(t.toPrecision(6))} s: ${told.join(", ")} ${shown.unit}`;
    const x = WIDE * (t - view[0]) / (view[1] - view[0]);
    cursors.forEach(([cursor]) => {
      cursor.setAttribute("d", `M${x} 0V${HIGH}`);
      cursor.setAttribute("visibility", "visible");
    });
  };
  charts.forEach((chart) => {
    const plot = chart.querySelector(".plot");
    plot.style.cursor = "crosshair";
    plot.style.touchAction = "pan-y";
    // Without a background the plot hears the pointer on its lines only.
    chart.querySelector(".area").prepend(svg("rect", { width: WIDE, height: HIGH, fill: "transparent" }));
    plot.addEventListener("pointerdown", (event) => {
      started = share(event, plot);
      plot.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    plot.addEventListener("pointermove", (event) => {
      const at = share(event, plot);
      read(at);
      cursors.forEach(([, chosen]) => {
        if (started === null || event.pointerType === "touch") return;
        chosen.setAttribute("x", WIDE * Math.min(at, started));
        chosen.setAttribute("width", WIDE * Math.abs(at - started));
        chosen.setAttribute("visibility", "visible");
      });
    });
    plot.addEventListener("pointerup", (event) => {
      const at = share(event, plot), begun = started;
      started = null;
      cursors.forEach(([, chosen]) => chosen.setAttribute("visibility", "hidden"));
      if (begun === null || event.pointerType === "touch" || Math.abs(at - begun) < 0.01) return;
      const wide = view[1] - view[0];
      show(view[0] + wide * Math.min(at, begun), view[0] + wide * Math.max(at, begun));
    });
    plot.addEventListener("pointerleave", () => {
      if (started !== null) return;
      readOut.textContent = hint;
      cursors.forEach(([cursor]) => cursor.setAttribute("visibility", "hidden"));
    });
    plot.addEventListener("dblclick", () => show(...shown.whole));
  });
  return {
    // `charts` has the lines of each chart, `whole` the ends of the time axis.
    hold: (content) => { shown = content; view = content.whole; },
    draw: () => show(...shown.whole),
  };
};
