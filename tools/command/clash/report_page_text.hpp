#pragma once
#include <string_view>

// Style and script of the page of clashes. Private to report_page.cpp.
namespace oncollide::tools {

inline constexpr std::string_view clash_page_style = R"(
:root { color-scheme: light dark; --ink: #1d232b; --paper: #ffffff; --soft: #5b6673; --line: #d4dae1; --band: #f3f5f8;
        --enclosed: #8e1b63; --crossing: #b3261e; --touching: #8a5a00; --within: #6b6b00; --near: #1f5fa8; --duplicate: #5b2a86; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ee; --paper: #15191f; --soft: #9aa6b4; --line: #343c47;
        --band: #1e242c; --enclosed: #f08cc8; --crossing: #ff8a80; --touching: #e9b44c; --within: #d2d268; --near: #7fb8f5; --duplicate: #c9a2f0; } }
body { font: 15px/1.5 "DejaVu Sans", Verdana, Helvetica, Arial, sans-serif; color: var(--ink); background: var(--paper);
       max-width: 1120px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.6em; margin-bottom: 0.2em; } h2 { font-size: 1.2em; margin-top: 2em; }
p { margin: 0.3em 0; } .soft { color: var(--soft); } .warning { border-left: 4px solid var(--touching); padding-left: 0.6em; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font-size: 13px; width: 100%; }
th, td { padding: 4px 8px; text-align: left; border-bottom: 1px solid var(--line); overflow-wrap: anywhere; }
thead th { border-bottom: 2px solid var(--soft); white-space: nowrap; } th button { all: unset; cursor: pointer; }
th button:focus-visible { outline: 2px solid var(--near); } th button::after { content: " \2195"; color: var(--soft); }
.number { text-align: right; white-space: nowrap; }
.enclosed { color: var(--enclosed); } .within { color: var(--within); } .crossing { color: var(--crossing); } .touching { color: var(--touching); }
.near { color: var(--near); } .duplicate { color: var(--duplicate); } .kind { font-weight: bold; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0.1em 1em; font-size: 13px; } dd { margin: 0; overflow-wrap: anywhere; }
a { color: var(--near); } tr:target, figure:target { outline: 2px solid var(--near); }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 480px), 1fr)); gap: 1.2em; }
figure { margin: 0; border: 1px solid var(--line); border-radius: 6px; background: var(--band); overflow: hidden; }
figure img { width: 100%; height: auto; display: block; } figcaption { padding: 0.5em 0.8em; font-size: 13px; overflow-wrap: anywhere; }
.filters { display: flex; flex-wrap: wrap; gap: 0.4em 1em; margin: 0.6em 0; font-size: 13px; align-items: center; }
select, input, .filters button { font: inherit; color: inherit; background: var(--paper); border: 1px solid var(--line);
  border-radius: 4px; padding: 1px 4px; } td input { width: 100%; box-sizing: border-box; } .filters button { cursor: pointer; }
tr.group th { background: var(--band); border-bottom: 1px solid var(--soft); } [hidden] { display: none; }
.matrix { width: auto; } .matrix td { text-align: right; } details > summary { cursor: pointer; color: var(--soft); }
@media print { .filters { display: none; } body { margin: 0; max-width: none; font-size: 10pt; } figure, tr { break-inside: avoid; } }
)";

/// Sorts tables, filters their rows, and keeps the statuses and comments that a reader sets: they go into the JSON
/// report that the page holds, and "Save" downloads it. Without scripts the page is readable, but without these.
inline constexpr std::string_view clash_page_script = R"(
"use strict";
const all = (selector, of = document) => [...of.querySelectorAll(selector)];
for (const button of all("th button")) button.addEventListener("click", () => {
  const head = button.parentElement, column = head.cellIndex;
  const up = head.getAttribute("aria-sort") !== "ascending";
  for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", up ? "ascending" : "descending");
  const key = row => { const cell = row.cells[column], key = cell.dataset.key, field = cell.querySelector("input, select");
    return key !== undefined ? +key : field ? field.value : cell.textContent; };
  for (const body of head.closest("table").tBodies) {
    const rows = all("tr[id]", body).sort((a, b) => { const p = key(a), q = key(b);
      return (typeof p === "number" ? p - q : p.localeCompare(q, undefined, {numeric: true})) * (up ? 1 : -1); });
    body.append(...rows);
  }
});
const holder = document.getElementById("report");
if (holder) {
  const report = JSON.parse(holder.textContent), bar = document.getElementById("filters");
  const clashes = new Map(report.clashes.map(clash => [clash.id, clash])), changed = new Set();
  const rows = all("tr[id]").filter(row => clashes.has(row.id) && row.dataset.status);
  const make = (tag, more) => Object.assign(document.createElement(tag), more);
  const save = make("button", {textContent: "Save JSON", disabled: true}), shown = make("span", {className: "soft"});
  const statusesOf = () => [...new Set(["new", "active", "approved", "reviewed", ...rows.map(row => row.dataset.status)])];
  const note = row => { changed.add(row.id); save.disabled = false; save.textContent = `Save JSON (${changed.size} changed)`; filter(); };
  for (const row of rows) {
    const clash = clashes.get(row.id), [statusCell, commentCell] = [row.cells[row.cells.length - 2], row.cells[row.cells.length - 1]];
    const status = make("select", {ariaLabel: "status"}), comment = make("input", {value: clash.comment, ariaLabel: "comment"});
    for (const name of statusesOf()) status.append(make("option", {textContent: name, selected: name === clash.status}));
    status.addEventListener("change", () => { row.dataset.status = clash.status = status.value; note(row); });
    comment.addEventListener("input", () => { clash.comment = comment.value; note(row); });
    statusCell.replaceChildren(status), commentCell.replaceChildren(comment);
  }
  const choice = (label, key) => {
    const values = [...new Set(rows.flatMap(row => (row.dataset[key] ?? "").split("\n")))].filter(text => text).sort();
    if (values.length < 2 && key !== "status") return () => true;
    const select = make("select", {ariaLabel: label});
    const fill = () => { const kept = select.value; const names = key === "status" ? statusesOf() : values;
      select.replaceChildren(...[`all: ${label}`, ...names].map((text, k) => make("option", {textContent: text, value: k ? text : ""})));
      select.value = kept; };
    fill(), select.addEventListener("change", () => filter()), bar.append(select);
    return row => !select.value || (row.dataset[key] ?? "").split("\n").includes(select.value);
  };
  const tests = [choice("status", "status"), choice("kind", "kind"), choice("class", "classes"), choice("storey", "storeys"),
                 choice("discipline", "disciplines")];
  const least = make("input", {type: "number", min: 0, step: "any", placeholder: `least size (${report.unit})`, ariaLabel: "least size"});
  const words = make("input", {type: "search", placeholder: "name", ariaLabel: "name"});
  for (const field of [least, words]) field.addEventListener("input", () => filter());
  tests.push(row => !least.value || +row.dataset.size >= +least.value);
  tests.push(row => row.textContent.toLowerCase().includes(words.value.toLowerCase()));
  const filter = () => {
    let count = 0;
    for (const row of rows) row.hidden = !tests.every(test => test(row)), count += !row.hidden;
    for (const heading of all("tr.group")) heading.hidden = all("tr[id]", heading.parentElement).every(row => row.hidden);
    for (const figure of all("figure[data-id]")) figure.hidden = document.getElementById(figure.dataset.id)?.hidden ?? false;
    shown.textContent = `${count} of ${rows.length} shown`;
  };
  save.addEventListener("click", () => {
    for (const status of ["new", "active"]) for (const kind in report.counts[status]) report.counts[status][kind] = 0;
    for (const {status, kind} of report.clashes)
      if (status !== "ignored" && status !== "contact") ++report.counts[status === "new" ? "new" : "active"][kind];
    const {clashes: list, resolved, ...head} = report;
    const lines = name => `"${name}": [` + report[name].map(item => "\n" + JSON.stringify(item)).join(",") + "]";
    const text = JSON.stringify(head).slice(0, -1) + ",\n" + lines("clashes") + ",\n" + lines("resolved") + "}\n";
    const link = make("a", {href: URL.createObjectURL(new Blob([text], {type: "application/json"})), download: "clashes.json"});
    link.click(), URL.revokeObjectURL(link.href);
  });
  bar.append(least, words, save, shown), bar.hidden = false, filter();
}
)";

} // namespace oncollide::tools
