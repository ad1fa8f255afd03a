#include "capture/page/page_html.h"

namespace reseau {

std::string_view page_html() {
  static constexpr std::string_view kPage = R"html(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>reseau</title>
<style>
  body { margin: 0; background: #222; color: #ddd; font: 15px/1.5 sans-serif; }
  header { padding: .6em 1em; position: sticky; top: 0; background: #222e; }
  progress { width: 100%; height: 6px; }
  #picture { position: relative; margin: 0 auto; max-width: 1200px; background: #111; }
  #picture img { display: block; width: 100%; }
  #picture img.missing { visibility: hidden; }
  pre { margin: 1em auto; max-width: 1200px; white-space: pre-wrap; font-size: 12px; }
  a { color: #9cf; }
</style>
<header><b id="phase">…</b> <span id="detail"></span>
<progress id="bar" max="1" value="0"></progress></header>
<div id="picture"></div>
<pre id="receipt"></pre>
<script>
"use strict";
const $ = (id) => document.getElementById(id);
const words = { waiting: "Waiting for the first line", scanning: "Scanning",
                finishing: "Finishing the picture", done: "Done" };
let shown = [];  // versions of the strips that are on the page

function show(state) {
  $("phase").textContent = words[state.phase] || state.phase;
  $("bar").value = state.lines ? state.lines_committed / state.lines : 0;
  let detail = state.lines ? `line ${state.lines_committed} of ${state.lines}` : "";
  if (state.lines_shown && !state.ended) {
    detail += `, provisional colour up to line ${state.lines_shown}`;
  } else if (state.lines_committed && !state.ended) {
    detail += ", looking for the réseau";
  }
  $("detail").textContent = state.message || detail;
  state.strips.forEach((version, i) => {
    if (version === (shown[i] || 0)) return;
    const rows = Math.min(state.strip_rows, state.height_px - i * state.strip_rows);
    while ($("picture").children.length <= i) {
      const strip = $("picture").appendChild(new Image(state.width_px, rows));
      strip.className = "missing";
    }
    const strip = $("picture").children[i];
    strip.onload = () => { strip.className = ""; };
    strip.src = `/strip/${i}.png?v=${version}`;
    shown[i] = version;
  });
}

async function finish(state) {
  if (state.view) {
    const picture = new Image();
    picture.onload = () => { $("picture").replaceChildren(picture); };
    picture.src = "/picture.png";
  }
  if (state.receipt) $("receipt").textContent = await (await fetch("/receipt.json")).text();
}

async function look() {
  let state;
  try {
    state = await (await fetch("/state.json")).json();
  } catch (gone) {
    $("phase").textContent = "The program has ended";
    return;
  }
  show(state);
  if (state.ended) return finish(state);
  setTimeout(look, 300);
}
look();
</script>
</html>
)html";
  return kPage;
}

}  // namespace reseau
