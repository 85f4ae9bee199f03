"use strict";
// The reason why a file makes no press. The page is loaded again as soon as the file is mended.
const text = document.getElementById("broken");
text.textContent = JSON.parse(document.getElementById("data").textContent).text;
const socket = new WebSocket(new URL("socket", location.href).href.replace(/^http/, "ws"));
socket.addEventListener("message", event => {
  const message = JSON.parse(event.data);
  if (message.type === "broken") text.textContent = message.text;
  if (message.type === "opened") location.reload();
});
socket.addEventListener("close", () => { text.textContent += " (pinpress has ended.)"; });
