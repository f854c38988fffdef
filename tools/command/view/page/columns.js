// Columns of numbers in base64, and the page's errors.
"use strict";
// Errors are shown on the page, not only in the console.
addEventListener("error", (e) => {
  const fault = document.getElementById("fault");
  fault.textContent = "Error on this page: " + (e.message || e.error);
  fault.hidden = false;
  document.documentElement.dataset.error = e.message || "unknown";
});
class Columns {
  constructor(id) {
    const text = atob(document.getElementById(id).textContent), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    this.buffer = bytes.buffer, this.at = 0;
  }
  take(Type, count) {
    const column = new Type(this.buffer, this.at, count);
    this.at += column.byteLength;
    return column;
  }
}
