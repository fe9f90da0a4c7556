"use strict";
/* Geometry of what is drawn: outer faces of layers, surfaces of tools, and from where all of a box is seen. */

const FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/* Faces of the kept cells that no kept cell lies behind: their cell, and their four nodes. */
function outerFaces({ cells, neighbours }, kept) {
  const found = [];
  const nodes = [];
  for (let cell = 0; cell < kept.length; cell++) {
    if (!kept[cell]) continue;
    for (let face = 0; face < 6; face++) {
      const behind = neighbours[6 * cell + face];
      if (behind >= 0 && kept[behind]) continue;
      found.push(cell);
      for (const corner of FACES[face]) nodes.push(cells[8 * cell + corner]);
    }
  }
  return { cells: Uint32Array.from(found), nodes: Uint32Array.from(nodes) };
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
