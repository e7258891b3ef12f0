
// Hides and shows methods in all charts.
document.querySelectorAll(".methods button").forEach((button) => {
  const { method, style } = button.dataset;
  button.addEventListener("click", () => {
    const shown = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", shown);
    document.querySelectorAll(`.area .${style}`).forEach((one) => { one.style.display = shown ? "" : "none"; });
    document.querySelectorAll("figure[data-method]").forEach((one) => {
      if (one.dataset.method === method) one.parentElement.hidden = !shown;
    });
  });
});

// Curves are read by the pointer, or by the arrow keys while they have the focus.
const comparison = embedded("comparison");
document.querySelectorAll("figure[data-curve]").forEach((figure) => {
  const curves = comparison.curves.filter((one) => one.name === figure.dataset.curve);
  const chart = figure.querySelector(".chart"), plot = chart.querySelector(".plot");
  const readOut = text("p", "Point at the curves to read them.", "read-out");
  readOut.setAttribute("role", "status");
  chart.after(readOut);
  const cursor = svg("path", { class: "cursor", d: "" });
  const area = chart.querySelector(".area");
  area.prepend(svg("rect", { width: WIDE, height: HIGH, fill: "transparent" }));
  area.append(cursor);
  const [low, high] = ends(chart, "data-x");
  const all = [...new Set(curves.flatMap((one) => one.x))].sort((a, b) => a - b);
  const hidden = (method) => [...document.querySelectorAll(".methods button")]
    .some((one) => one.dataset.method === method && one.getAttribute("aria-pressed") === "false");
  const number = (value) => String(Number(value.toPrecision(3)));
  let row = -1;
  const read = (k) => {
    row = Math.min(all.length - 1, Math.max(0, k));
    const told = curves.filter((one) => !hidden(one.method) && one.x.includes(all[row])).map((one) => {
      const at = one.x.indexOf(all[row]);
      return `${one.method} ${number(one.mean[at])} [${number(one.low[at])}, ${number(one.high[at])}]`;
    });
    readOut.textContent = `${figure.dataset.along} ${all[row]}: ${told.join(", ")}`;
    cursor.setAttribute("d", `M${WIDE * (all[row] - low) / (high - low)} 0V${HIGH}`);
  };
  plot.addEventListener("pointermove", (event) => {
    const box = plot.getBoundingClientRect();
    read(nearest(all, low + (high - low) * (event.clientX - box.left) / box.width));
  });
  figure.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!by) return;
    event.preventDefault();
    read(row + by);
  });
});
document.documentElement.dataset.script = "ready";
