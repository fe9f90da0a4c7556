"use strict";
/* Geometry of what is drawn: outer faces of layers, surfaces of tools, and from where all of a box is seen. */

const FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

const EDGES = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
const [BEFORE, CUT, BEYOND] = [0, 1, 2];

/* A plane across an undeformed axis: where nodes and cells lie to it. */
class Plane {
  constructor({ points, cells }, axis, place) {
    Object.assign(this, { points, cells, axis, place });
    this.slack = 1e-9 * Math.max(1e-3, Math.abs(place));
  }

  /* How far a node lies beyond it in m; exactly on it where it nearly is. */
  beyond(node) {
    const away = this.points[3 * node + this.axis] - this.place;
    return Math.abs(away) < this.slack ? 0 : away;
  }

  side(cell) {
    let [before, beyond] = [false, false];
    for (let corner = 0; corner < 8; corner++) {
      const away = this.beyond(this.cells[8 * cell + corner]);
      if (away < 0) before = true;
      if (away > 0) beyond = true;
    }
    return !beyond ? BEFORE : before ? CUT : BEYOND;
  }

  /* Where an edge from node a to node b meets it. */
  crossing(a, b) {
    const [from, to] = [this.beyond(a), this.beyond(b)];
    return { node: a, other: b, share: from / (from - to) };
  }

  /* What is beyond it of a face, as a polygon. */
  clipped(nodes) {
    return nodes.flatMap((node, i) => {
      const next = nodes[(i + 1) % nodes.length];
      const [here, there] = [this.beyond(node), this.beyond(next)];
      const kept = here >= 0 ? [{ node, other: node, share: 0 }] : [];
      return here * there < 0 ? [...kept, this.crossing(node, next)] : kept;
    });
  }

  /* Where it cuts through a cell, as a polygon. */
  section(cell) {
    const nodes = Array.from(this.cells.subarray(8 * cell, 8 * cell + 8));
    const found = nodes.filter((node) => this.beyond(node) === 0).map((node) => ({ node, other: node, share: 0 }));
    for (const [a, b] of EDGES) {
      if (this.beyond(nodes[a]) * this.beyond(nodes[b]) < 0) found.push(this.crossing(nodes[a], nodes[b]));
    }
    const [first, second] = [0, 1, 2].filter((axis) => axis !== this.axis);
    const at = ({ node, other, share }, axis) => {
      const from = this.points[3 * node + axis];
      return from + share * (this.points[3 * other + axis] - from);
    };
    const middle = [first, second].map((axis) => found.reduce((sum, one) => sum + at(one, axis), 0) / found.length);
    const angle = (one) => Math.atan2(at(one, second) - middle[1], at(one, first) - middle[0]);
    return found.sort((a, b) => angle(a) - angle(b));
  }
}

/* Faces that are seen of all cells, or of what lies beyond a plane: of each its cell, and four corners on edges from a
   node to another one, at a share of the edge. */
function outerFaces({ cells, neighbours }, plane) {
  const found = { cells: [], nodes: [], others: [], shares: [] };
  const putWhole = (cell, nodes) => {
    found.cells.push(cell);
    found.nodes.push(...nodes);
    found.others.push(...nodes);
    found.shares.push(0, 0, 0, 0);
  };
  const put = (cell, polygon) => {
    for (let i = 1; i + 1 < polygon.length; i += 2) {
      found.cells.push(cell);
      for (const { node, other, share } of [polygon[0], polygon[i], polygon[i + 1], polygon[i + 2] ?? polygon[i + 1]]) {
        found.nodes.push(node);
        found.others.push(other);
        found.shares.push(share);
      }
    }
  };
  const count = cells.length / 8;
  const sides = Uint8Array.from({ length: count }, (_, cell) => (plane ? plane.side(cell) : BEYOND));
  for (let cell = 0; cell < count; cell++) {
    if (sides[cell] === BEFORE) continue;
    for (let face = 0; face < 6; face++) {
      const behind = neighbours[6 * cell + face];
      if (behind >= 0 && sides[behind] !== BEFORE) continue;
      const nodes = FACES[face].map((corner) => cells[8 * cell + corner]);
      if (sides[cell] === CUT) put(cell, plane.clipped(nodes));
      else putWhole(cell, nodes);
    }
    if (sides[cell] === CUT) put(cell, plane.section(cell));
  }
  const whole = (numbers) => Uint32Array.from(numbers);
  return { cells: whole(found.cells), nodes: whole(found.nodes), others: whole(found.others), shares: Float32Array.from(found.shares) };
}

/* Two triangles and four edges of each of some faces with four corners of their own. */
function cornersOf(faces) {
  const triangles = new Uint32Array(6 * faces);
  const edges = new Uint32Array(8 * faces);
  for (let face = 0; face < faces; face++) {
    const a = 4 * face;
    triangles.set([a, a + 1, a + 2, a, a + 2, a + 3], 6 * face);
    edges.set([a, a + 1, a + 1, a + 2, a + 2, a + 3, a + 3, a], 8 * face);
  }
  return { triangles, edges };
}

/* A surface given as rows of points. */
function gridGeometry({ grid, rows }) {
  const points = Float32Array.from(grid);
  const columns = points.length / 3 / rows;
  const corners = [];
  for (let row = 0; row + 1 < rows; row++) {
    for (let column = 0; column + 1 < columns; column++) {
      const a = row * columns + column;
      corners.push(a, a + 1, a + columns, a + 1, a + columns + 1, a + columns);
    }
  }
  const geometry = new vendor.BufferGeometry();
  geometry.setAttribute("position", new vendor.BufferAttribute(points, 3));
  geometry.setIndex(corners);
  return geometry;
}

/* Distance from the middle of a box at which a camera, away in a direction, sees all its corners. */
function distanceFor(box, away, camera) {
  const right = camera.up.clone().cross(away).normalize();
  const up = away.clone().cross(right);
  const tall = Math.tan((Math.PI / 360) * camera.fov);
  const half = box.max.clone().sub(box.min).multiplyScalar(0.5);
  let distance = 0;
  for (const signs of [[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1]]) {
    const corner = new vendor.Vector3(...signs).multiply(half);
    const [x, y, z] = [right, up, away].map((axis) => Math.abs(corner.dot(axis)));
    distance = Math.max(distance, z + x / (tall * camera.aspect), z + y / tall);
  }
  return distance;
}
