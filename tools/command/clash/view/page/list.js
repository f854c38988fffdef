// The list of clashes, the worst first, and the text about the choice.
const element = (kind, attributes, ...children) => {
  const [tag, name] = kind.split("."), made = Object.assign(document.createElement(tag), attributes);
  if (name) made.className = name;
  made.append(...children.filter((child) => child !== null));
  return made;
};
const rowsAtATime = 300;
const labels = header.labels, textOf = (part) => [labels[part], ...Object.values(header.details[part])].join(" ");
const words = header.clashes.map((c) => `${c.kind} ${c.status} ${c.comment || ""} ${textOf(c.a)} ${textOf(c.b)}`.toLowerCase());

// Names are cut in the middle: their beginnings are often the same.
const short = (text, most = 36) => (text.length <= most ? text : `${text.slice(0, most / 2)}…${text.slice(1 - most / 2)}`);

// A bit per clash: true if it fits the filters.
function listedBy({search, kind, status, part}) {
  const wanted = search.toLowerCase().split(/\s+/).filter((word) => word);
  return header.clashes.map((c, k) => (!kind || c.kind === kind) && (!status || c.status === status) && (part < 0 || c.a === part || c.b === part) && wanted.every((word) => words[k].includes(word)));
}

function fillChoices(id, name) {
  const values = [...new Set(header.clashes.map((c) => c[id]))];
  $(id).replaceChildren(element("option", {value: ""}, `all ${name}`), ...values.map((value) => element("option", {value}, value)));
  $(id).hidden = values.length < 2;
}

function fillRows(listed, chosen, most, choose) {
  const numbers = [];
  listed.forEach((is, k) => is && numbers.push(k));
  $("rows").replaceChildren(...numbers.slice(0, most).map((k) => {
    const c = header.clashes[k];
    return element("li", {}, element("button", {id: "row" + k, title: `${labels[c.a]}\n${labels[c.b]}`, onclick: () => choose(k)}, element("span.number", {}, String(k + 1)),
      element("span.names", {}, short(labels[c.a])), element("span.size", {}, c.size), element("span.names", {}, short(labels[c.b])),
      element("span.kind", {}, element("span", {className: "dot " + c.kind}), c.kind + (c.status === "new" ? "" : `, ${c.status}`))));
  }));
  markRow(chosen);
  $("more").hidden = numbers.length <= most;
  $("shown").textContent = numbers.length === header.clashes.length ? `${numbers.length.toLocaleString("en")}, the worst first` : `${numbers.length.toLocaleString("en")} of ${header.clashes.length.toLocaleString("en")}`;
}
function markRow(chosen) {
  for (const row of document.querySelectorAll("#rows [aria-current]")) row.removeAttribute("aria-current");
  const row = $("row" + chosen);
  if (row) row.setAttribute("aria-current", "true"), row.scrollIntoView({block: "nearest"});
}

function partBox(part, name, acts) {
  const details = header.details[part], text = ["class", "type", "storey", "discipline"].filter((key) => details[key]).map((key) => details[key]).join(" · ");
  return element("div.part", {}, element("span", {className: "dot square " + name}), element("b", {}, labels[part]), text ? element("p", {}, text) : null,
    details.GlobalId ? element("p", {}, details.GlobalId) : null,
    element("div.row", {}, ...acts.map(([label, act, pressed]) => element("button", {onclick: act, ariaPressed: pressed === undefined ? null : String(pressed)}, label))));
}
