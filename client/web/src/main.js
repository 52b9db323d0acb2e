// Where a page begins: finds its kind and data in the document and fills it.
import { element } from "./element.js";
import { reportPage } from "./report.js";
import { sweepPage } from "./sweep.js";
import "./style.css";

const kPages = { report: reportPage, sweep: sweepPage };

const data = JSON.parse(document.getElementById("data").textContent);
const main = document.querySelector("main");
main.replaceChildren();
kPages[document.body.dataset.page](main, data);
main.append(element("footer", {}, `Made by Isolux ${document.body.dataset.version}`));
