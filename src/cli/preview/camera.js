// A camera that is led around: {eye, target, roll, lens, orthographic}, as the server tells it. Angles are in degrees.
"use strict";

const plus = (a, b, k = 1) => a.map((x, i) => x + k * b[i]);
const times = (a, k) => a.map(x => x * k);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const radians = degrees => degrees * Math.PI / 180;
/** Turns around straight up and down end so far before them, degrees: there is no right and left. */
const STEEPEST = 89.5;

/** Where the eye is around the target: azimuth (0: +Z, 90: +X), elevation, distance. */
function orbitOf({eye, target}) {
  const way = plus(eye, target, -1), distance = Math.hypot(...way);
  return [Math.atan2(way[0], way[2]) / radians(1), Math.asin(way[1] / distance) / radians(1), distance];
}

/** To the right of the picture and to its top. */
function axesOf(camera) {
  const [azimuth, , distance] = orbitOf(camera), [sin, cos] = [Math.sin(radians(azimuth)), Math.cos(radians(azimuth))];
  const forward = times(plus(camera.target, camera.eye, -1), 1 / distance), level = [cos, 0, -sin];
  const up = cross(level, forward), [s, c] = [Math.sin(radians(camera.roll)), Math.cos(radians(camera.roll))];
  return [plus(times(level, c), up, -s), plus(times(up, c), level, s)];
}

/** Around the target, by degrees to the right and upwards. */
function orbited(camera, right, up) {
  const [azimuth, elevation, distance] = orbitOf(camera);
  const steepest = Math.max(STEEPEST, Math.abs(elevation));
  const [a, e] = [radians(azimuth + right), radians(Math.min(Math.max(elevation + up, -steepest), steepest))];
  const way = [Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e)];
  return {...camera, eye: plus(camera.target, way, distance)};
}

/** Sideways, so that what is as far away as the target moves by shares of the picture's height to the right and upwards. */
function panned(camera, right, up) {
  const [, , distance] = orbitOf(camera), [x, y] = axesOf(camera);
  const height = camera.orthographic ? camera.lens : 2 * distance * Math.tan(radians(camera.lens) / 2);
  const by = plus(times(x, -right * height), y, -up * height);
  return {...camera, eye: plus(camera.eye, by), target: plus(camera.target, by)};
}

/** So many times as near: by its distance, or by what it sees where that has no say. */
function zoomed(camera, times) {
  if (camera.orthographic) {
    const lens = camera.lens / times;
    return lens > 1e-18 && lens < 1e18 ? {...camera, lens} : camera;
  }
  const way = plus(camera.eye, camera.target, -1), eye = plus(camera.target, way, 1 / times);
  const far = Math.hypot(...way) / times, least = 1e-6 * Math.max(1e-6, ...camera.target.map(Math.abs));
  return far > least && far < 1e15 ? {...camera, eye} : camera;
}

/** As the server reads it. */
function written({eye, target, roll, lens}) { return [...eye, ...target, roll, lens].join(","); }
