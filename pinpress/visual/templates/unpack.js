"use strict";
// The page's libraries, data and program are deflated and written in base 85 (RFC 1924). They are opened, and run in their order.
function bytesOf(text) {
  const digits = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;<=>?@^_`{|}~", value = new Uint8Array(128);
  for (let i = 0; i < 85; i++) value[digits.charCodeAt(i)] = i;
  const words = Math.ceil(text.length / 5), missing = 5 * words - text.length, view = new DataView(new ArrayBuffer(4 * words));
  for (let i = 0; i < words; i++) {
    let word = 0;
    for (let k = 5 * i; k < 5 * i + 5; k++) word = 85 * word + (k < text.length ? value[text.charCodeAt(k)] : 84);
    view.setUint32(4 * i, word);
  }
  return new Uint8Array(view.buffer, 0, 4 * words - missing);
}

async function unpack() {
  if (!self.DecompressionStream) throw new Error("this browser is too old for it; Chrome and Edge 80, Firefox 113, Safari 16.4 and later show it");
  for (const packed of document.querySelectorAll("script.packed")) {
    const opened = new Blob([bytesOf(packed.textContent)]).stream().pipeThrough(new DecompressionStream("deflate"));
    const text = await new Response(opened).text();
    if (packed.type === "application/json") { packed.textContent = text; continue; }
    const script = document.createElement("script");
    script.textContent = text;
    packed.replaceWith(script);
  }
}

// Programs that print a page or take its picture wait for its load event, and this for a frame whose document is not closed.
const held = document.documentElement.appendChild(Object.assign(document.createElement("iframe"), { hidden: true }));
held.contentDocument.open();

const unpacked = new Promise(done => addEventListener("DOMContentLoaded", done)).then(unpack).finally(() => {
  held.contentDocument.close();
  held.remove();
}).catch(error => {
  const message = document.createElement("p");
  message.className = "message";
  message.setAttribute("role", "alert");
  message.textContent = "The page cannot be opened: " + error.message + ".";
  document.body.prepend(message);
  throw error;
});
