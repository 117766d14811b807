// Draw every diagram once it can be seen, keep the time axes together, follow light and dark, fit the printer.
"use strict";
(() => {
  // The buttons are listed, and the server left empty: plotly's own set has one that uploads the data.
  const config = {
    responsive: true, displaylogo: false, plotlyServerURL: "", toImageButtonOptions: {format: "svg"},
    modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
  };
  const NARROW = 600;  // [px]
  const plots = [];
  let shown = null;  // range of time that the reader chose
  let busy = false;
  const ink = () => getComputedStyle(document.documentElement).getPropertyValue("--ink").trim();
  const paper = () => getComputedStyle(document.documentElement).getPropertyValue("--paper").trim();
  const theme = () => ({"font.color": ink(), "hoverlabel.bgcolor": paper(), "hoverlabel.font.color": ink()});
  const linked = () => plots.filter((plot) => "linked" in plot.dataset);

  function follow(plot) {
    plot.on("plotly_relayout", (event) => {
      if (busy || !Object.keys(event).some((key) => key.startsWith("xaxis"))) return;
      busy = true;
      shown = [...plot.layout.xaxis.range];
      const others = linked().filter((other) => other !== plot);
      Promise.all(others.map((other) => Plotly.relayout(other, {"xaxis.range": [...shown]})))
        .finally(() => { busy = false; });
    });
  }

  function draw(source) {
    const plot = document.getElementById(source.dataset.plot);
    if (plots.includes(plot)) return;
    const {data, layout} = JSON.parse(source.textContent);
    layout.font.color = ink();
    layout.hoverlabel = {bgcolor: paper(), font: {color: ink()}};
    if (shown && "linked" in plot.dataset) layout.xaxis.range = [...shown];
    const narrow = plot.clientWidth < NARROW;
    if (narrow) {
      layout.font.size = 11;
      layout.margin.l = Math.min(layout.margin.l, 96);
    }
    Plotly.newPlot(plot, data, layout, narrow ? {...config, displayModeBar: false} : config);
    plots.push(plot);
    if ("linked" in plot.dataset) follow(plot);
  }

  const sources = [...document.querySelectorAll("script[data-plot]")];
  const drawVisible = () => { for (const source of sources) if (!source.closest("details:not([open])")) draw(source); };
  drawVisible();
  for (const fold of document.querySelectorAll("details")) fold.addEventListener("toggle", drawVisible);

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const plot of plots) Plotly.relayout(plot, theme());
  });
  addEventListener("beforeprint", () => {
    drawVisible();
    for (const plot of plots) Plotly.relayout(plot, {...theme(), width: 680, autosize: false});
  });
  addEventListener("afterprint", () => {
    for (const plot of plots) Plotly.relayout(plot, {...theme(), width: null, autosize: true});
  });
})();
