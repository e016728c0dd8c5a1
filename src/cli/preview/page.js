// The page: which picture is wanted, which one is on its way, and who changes that.
"use strict";
const at = id => document.getElementById(id);
/** A drag over the picture's height turns the camera by so many degrees. */
const TURN = 180;
/** Full pictures of a camera that is led around are asked for when it has rested for so long, milliseconds. */
const REST = 250;
/** The server renders one view for each page. */
const PAGE = Math.floor(Math.random() * 2 ** 48);

let state = {version: 0, runs: [], rate: 24, size: [0, 0]}, frames = [], place = 0, playing = false;
// a camera that was let go of the shot's, and when it moved last
let free = null, moved = 0, letting = null;
// why its picture could not be rendered
let refused = "";
// what is on its way, and what is shown: {name, detail}
let loading = null, shown = {};

function listed(runs) {
  const all = new Set();
  for (const [first, last, step] of runs) for (let frame = first; frame <= last; frame += step) all.add(frame);
  return [...all].sort((a, b) => a - b);
}

function go(to) {
  if (!frames.length) return;
  place = Math.min(Math.max(to, 0), frames.length - 1);
  at("place").value = place;
  at("number").textContent = "frame " + frames[place];
  show();
}

function turn() { go(place + 1 < frames.length ? place + 1 : 0); }

/** Which picture is to be seen; its address but for the detail of a view. */
function wanted() {
  const here = state.version + "/" + frames[place];
  return free ? ["view/" + here + "/" + PAGE + "/", "/" + written(free)] : ["frame/" + here, ""];
}

// one request at a time; when it is there, what is wanted by then
async function show() {
  if (!frames.length || state.error) return;
  const parts = wanted(), name = parts.join("|");
  if (loading) {
    // the server forgets a view when the page wants another one
    if (free && loading.name !== name && loading.detail === "full") loading.abort.abort();
    return;
  }
  let detail = free ? "coarse" : "";
  if (free && shown.name === name) {
    if (shown.detail === "full" || playing) return;
    const rested = performance.now() - moved;
    if (rested < REST) return void setTimeout(show, REST - rested + 1);
    detail = "full";
  } else if (shown.name === name) {
    return;
  }
  const version = state.version, frame = frames[place], start = performance.now();
  loading = {name, detail, abort: new AbortController()};
  at("status").textContent = "rendering frame " + frame + " ...";
  at("picture").classList.toggle("old", !free);
  let pause = 0;
  try {
    const answer = await fetch(parts.join(detail), {signal: loading.abort.signal});
    if (answer.ok && version === state.version) {
      await paint(await answer.blob());
      shown = {name, detail};
      const seconds = answer.headers.get("X-Seconds") + " s";
      at("status").textContent = detail === "coarse" ? "coarse, " + seconds : seconds;
      pause = playing ? Math.max(0, 1000 / state.rate - (performance.now() - start)) : 0;
    } else if (answer.status === 500) {
      // this camera cannot be shown, and the shot's can
      reset();
      at("error").textContent = refused = await answer.text();
      at("error").hidden = false;
    } else {
      pause = 300;
    }
  } catch (error) {
    pause = loading.abort.signal.aborted ? 0 : 1000;
  }
  setTimeout(() => {
    loading = null;
    if (playing && shown.name === wanted().join("|")) turn(); else show();
  }, pause);
}

async function paint(blob) {
  const picture = at("picture"), url = URL.createObjectURL(blob), before = picture.src;
  picture.src = url;
  await picture.decode();
  if (before) URL.revokeObjectURL(before);
  picture.hidden = false;
  picture.classList.remove("old");
  fit();
}

// coarse pictures are as large as full ones
function fit() {
  const [width, height] = state.size, stage = at("stage");
  const scale = Math.min(1, stage.clientWidth / width, stage.clientHeight / height);
  at("picture").style.width = width * scale + "px";
  at("picture").style.height = height * scale + "px";
}

function play(on) {
  playing = on;
  at("play").textContent = on ? "stop" : "play";
  if (on && !loading) turn(); else show();
}

async function look() {
  try {
    const found = await (await fetch("state")).json();
    if (found.version !== state.version) {
      const frame = frames[place];
      [state, refused] = [found, ""];
      document.title = state.title + " - Afterimage preview";
      at("title").textContent = state.title;
      at("notes").textContent = (state.notes || []).join("\n");
      if (state.runs.length) {
        frames = listed(state.runs);
        at("place").max = frames.length - 1;
      }
      if (free && !state.error) await check();
      go(Math.max(0, frames.indexOf(frame)));
    }
    at("error").textContent = found.error || refused;
    at("error").hidden = !at("error").textContent;
    if (found.error) at("status").textContent = "";
    fit();
  } catch (error) {
    at("status").textContent = "the preview has ended";
  }
  setTimeout(look, 400);
}

async function shotCamera() {
  const answer = await fetch("camera/" + state.version + "/" + frames[place]);
  return answer.ok ? answer.json() : null;
}

// a shot that has another kind of camera by now has no use for this one
async function check() {
  const camera = await shotCamera();
  if (camera && camera.orthographic !== free.orthographic) reset();
}

/** Moves the camera; the first time it is let go of the shot's. */
async function move(how) {
  if (!frames.length || state.error) return;
  if (!free) {
    letting = letting || shotCamera();
    const camera = await letting;
    letting = null;
    free = free || camera;
    if (!free) return;
  }
  free = how(free);
  refused = "";
  moved = performance.now();
  at("reset").disabled = false;
  show();
}

function reset() {
  free = null;
  at("reset").disabled = true;
  at("key").hidden = true;
  show();
}

// the text is there to be copied by hand where the page may not do it
async function copy() {
  if (!frames.length) return;
  const camera = free || await shotCamera();
  const answer = camera && await fetch("key/" + state.version + "/" + frames[place] + "/" + written(camera));
  if (!answer || !answer.ok) return;
  at("text").value = await answer.text();
  at("key").hidden = false;
  fit();
  let copied = true;
  try { await navigator.clipboard.writeText(at("text").value); } catch (error) { copied = false; }
  at("text").focus();
  at("text").select();
  at("text").scrollTop = 0;
  at("status").textContent = copied ? "copied" : "copy the text below";
}

// left: orbit; middle, or with Shift: pan. One finger orbits, two pan and zoom.
const held = new Map();
const stage = at("stage");
const middle = points => points.reduce(([x, y], p) => [x + p[0] / points.length, y + p[1] / points.length], [0, 0]);
const spread = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);

stage.addEventListener("pointerdown", event => {
  if (event.button > 1) return;
  event.preventDefault();
  stage.setPointerCapture(event.pointerId);
  held.set(event.pointerId, [event.clientX, event.clientY]);
  stage.classList.add("held");
});
stage.addEventListener("pointermove", event => {
  if (!held.has(event.pointerId)) return;
  const before = [...held.values()];
  held.set(event.pointerId, [event.clientX, event.clientY]);
  const now = [...held.values()], [x0, y0] = middle(before), [x1, y1] = middle(now);
  const height = at("picture").clientHeight || 1, [x, y] = [(x1 - x0) / height, (y1 - y0) / height];
  const apart = held.size > 1 ? spread(now) / Math.max(spread(before), 1) : 1;
  const pans = held.size > 1 || event.shiftKey || (event.buttons & 4) !== 0;
  if (!x && !y && apart === 1) return;
  move(camera => pans ? zoomed(panned(camera, x, -y), Math.max(apart, 0.1)) : orbited(camera, -x * TURN, y * TURN));
});
for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, event => {
  held.delete(event.pointerId);
  if (!held.size) stage.classList.remove("held");
});
stage.addEventListener("wheel", event => {
  event.preventDefault();
  if (event.deltaY) {
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 100 : event.deltaY / 3;
    move(camera => zoomed(camera, 1.1 ** -Math.min(Math.max(lines, -5), 5)));
  }
}, {passive: false});
// the middle button scrolls, or pastes
for (const other of ["mousedown", "auxclick"]) stage.addEventListener(other, event => event.preventDefault());

at("first").onclick = () => go(0);
at("back").onclick = () => go(place - 1);
at("play").onclick = () => play(!playing);
at("next").onclick = () => go(place + 1);
at("last").onclick = () => go(frames.length - 1);
at("place").oninput = event => go(Number(event.target.value));
at("copy").onclick = copy;
at("reset").onclick = reset;
at("close").onclick = () => { at("key").hidden = true; fit(); };
addEventListener("resize", fit);
addEventListener("keydown", event => {
  const keys = {ArrowLeft: () => go(place - 1), ArrowRight: () => go(place + 1), Home: () => go(0),
                End: () => go(frames.length - 1), " ": () => play(!playing)};
  if (event.ctrlKey || event.metaKey || event.altKey || event.target === at("text") || !keys[event.key]) return;
  event.preventDefault();
  keys[event.key]();
});
look();
