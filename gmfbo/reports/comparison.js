
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
document.documentElement.dataset.script = "ready";
