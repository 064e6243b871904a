import "./style.css";
import { readBlock, readHead } from "./data.js";
import { el } from "./dom.js";
import { livePage } from "./live.js";
import { recordedPage } from "./recorded.js";

async function start() {
  const page = document.getElementById("page");
  const head = readHead();
  try {
    if (head.kind === "recorded") recordedPage(page, head, await readBlock());
    else if (head.kind === "live") livePage(page, head);
    else throw new Error(`a page of the kind "${head.kind}" is not known`);
    document.documentElement.dataset.ready = "yes";
  } catch (error) {
    page.replaceChildren(el("p.failure", {}, `This page cannot be drawn: ${error.message}`));
    throw error;
  }
}

start();
