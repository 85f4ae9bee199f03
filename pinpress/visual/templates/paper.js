// ---- paper: while it is printed, the page is laid out for it, and an image stands in place of the press ----
const DOTS = 3;  // pixels of the image for each of the page, 290 an inch
const forPaper = [];  // what else is done for it: functions, each of which returns one that takes it back
let takeBack = [];
const plots = () => [...document.querySelectorAll(".plot")].filter(plot => plot._fullLayout);

function toPaper() {
  if (document.body.classList.contains("paper")) return;
  setPlaying(false);
  document.body.classList.add("paper");
  viewer.renderer.setPixelRatio(DOTS);
  resize();
  seek(now);  // labels and charts
  viewer.render();
  const snapshot = document.createElement("img");
  snapshot.id = "snapshot";
  snapshot.alt = `${say("The press at")} ${element("slider").ariaValueText}`;
  snapshot.src = viewer.renderer.domElement.toDataURL();  // what is on the canvas is lost after this event
  element("view").prepend(snapshot);
  takeBack = forPaper.map(act => act());
  for (const plot of plots()) Plotly.relayout(plot, { autosize: false, width: plot.clientWidth, height: plot.clientHeight });
}

function toScreen() {
  if (!document.body.classList.contains("paper")) return;
  document.body.classList.remove("paper");
  element("snapshot").remove();
  viewer.renderer.setPixelRatio(devicePixelRatio);
  resize();
  takeBack.forEach(act => act());
  for (const plot of plots()) Plotly.relayout(plot, { autosize: true, width: null, height: null });
  seek(now);
}

addEventListener("beforeprint", toPaper);
addEventListener("afterprint", toScreen);
