"use strict";
// What a page of charts begins with where no press moves; elsewhere the player has these.
const element = id => document.getElementById(id);
const data = JSON.parse(element("data").textContent);
const floats = text => new Float32Array(Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer);
