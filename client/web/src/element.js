// Makes elements of a page. Text is always set as text: nothing that comes from data is ever read as
// markup.

/**
 * An element with attributes (null and false are left out) and children (nodes, texts, or lists of
 * either; null is left out).
 */
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return made;
}
