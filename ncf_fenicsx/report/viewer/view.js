"use strict";
/* The deformed stack of one run in 3-D, with its tools. Layers are drawn flat: a colour for each cell or node. */

const MOST_EDGES = 50000;
const MOST_CUT = 0.999;
const SIDES = { corner: [-0.9, -1.3, 0.9], front: [0, -1, 0.0001], side: [-1, 0, 0.0001], above: [0, -0.0001, 1] };

class View {
  constructor(canvas, model, colours) {
    this.canvas = canvas;
    this.model = model;
    this.renderer = new vendor.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.localClippingEnabled = true; // a cut goes through tools too
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.camera = new vendor.PerspectiveCamera(30, 1, 0.001, 10);
    this.camera.up.set(0, 0, 1);
    this.scene = new vendor.Scene();
    this.lamp = new vendor.DirectionalLight(0xffffff, 1.0);
    this.scene.add(new vendor.AmbientLight(0xffffff, 2.4), this.lamp);
    this.makeMaterials(colours);
    this.images = new vendor.Group();
    this.scene.add(this.images);
    this.tools = model.surfaces.map((surface) => this.makeTool(surface));
    this.orbit = new vendor.OrbitControls(this.camera, canvas);
    this.orbit.addEventListener("change", () => this.moved());
    this.onmove = () => {};
    this.cutAt(null, 0);
    this.mirror(false);
  }

  makeMaterials(colours) {
    const texture = new vendor.DataTexture(colours, colours.length / 4, 1, vendor.RGBAFormat);
    texture.colorSpace = vendor.SRGBColorSpace;
    texture.magFilter = texture.minFilter = vendor.LinearFilter;
    texture.needsUpdate = true;
    const offset = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    const flat = { flatShading: true, side: vendor.DoubleSide };
    this.fabric = new vendor.MeshLambertMaterial({ map: texture, ...flat, ...offset });
    this.steel = new vendor.MeshLambertMaterial({ color: 0x8a8f98, transparent: true, opacity: 0.45, ...flat });
    this.steel.depthWrite = false;
    this.ink = new vendor.LineBasicMaterial({ transparent: true, opacity: 0.35 });
  }

  makeTool(surface) {
    const tool = new vendor.Mesh(gridGeometry(surface), this.steel);
    this.scene.add(tool);
    return tool;
  }

  /* Shows what lies beyond a plane at a share of the undeformed extent along an axis, in m; all for null. */
  cutAt(axis, share) {
    let place = null;
    if (axis !== null) {
      const [low, high] = this.extent(axis);
      place = low + Math.min(share, MOST_CUT) * (high - low);
    }
    this.faces = outerFaces(this.model, place === null ? null : new Plane(this.model, axis, place));
    const along = new vendor.Vector3().setComponent(axis ?? 0, 1);
    this.steel.clippingPlanes = place === null ? null : [{ normal: along, constant: -place }];
    this.makeGeometry();
    return place;
  }

  /* Least and largest undeformed coordinate along an axis in m. */
  extent(axis) {
    const { points } = this.model;
    let low = Infinity;
    let high = -Infinity;
    for (let i = axis; i < points.length; i += 3) {
      low = Math.min(low, points[i]);
      high = Math.max(high, points[i]);
    }
    return [low, high];
  }

  centre(cell, axis) {
    let sum = 0;
    for (let corner = 0; corner < 8; corner++) sum += this.model.points[3 * this.model.cells[8 * cell + corner] + axis];
    return sum / 8;
  }

  makeGeometry() {
    const corners = this.faces.nodes.length;
    const { triangles, edges } = cornersOf(this.faces.cells.length);
    this.geometry?.dispose();
    this.outline?.dispose();
    this.position = new vendor.BufferAttribute(new Float32Array(3 * corners), 3).setUsage(vendor.DynamicDrawUsage);
    this.colour = new vendor.BufferAttribute(new Float32Array(2 * corners).fill(0.5), 2).setUsage(vendor.DynamicDrawUsage);
    this.geometry = new vendor.BufferGeometry();
    this.geometry.setAttribute("position", this.position);
    this.geometry.setAttribute("uv", this.colour);
    this.geometry.setIndex(new vendor.BufferAttribute(triangles, 1));
    this.outline = new vendor.BufferGeometry();
    this.outline.setAttribute("position", this.position);
    this.outline.setIndex(new vendor.BufferAttribute(edges, 1));
    this.mirror(this.mirrored ?? false);
  }

  mirror(mirrored) {
    this.mirrored = mirrored;
    this.images.clear();
    let images = [[]];
    if (mirrored) for (const plane of this.model.mirrors) images = images.flatMap((image) => [image, [...image, plane]]);
    for (const image of images) {
      for (const part of [new vendor.Mesh(this.geometry, this.fabric), new vendor.LineSegments(this.outline, this.ink)]) {
        for (const { axis, at } of image) {
          part.scale.setComponent(axis, -1);
          part.position.setComponent(axis, 2 * at);
        }
        part.frustumCulled = false;
        part.userData.edges = part.isLineSegments;
        this.images.add(part);
      }
    }
    this.edges(this.edged ?? this.faces.cells.length <= MOST_EDGES);
  }

  edges(edged) {
    this.edged = edged;
    for (const part of this.images.children) if (part.userData.edges) part.visible = edged;
    this.draw();
  }

  rigid(shown) {
    for (const tool of this.tools) tool.visible = shown;
    this.draw();
  }

  /* Shows a step of a field; colours run from low to high; layers are apart by a length in m. */
  show(step, shown, low, high, scale, apart) {
    const { points, nodes, layer } = this.model;
    const moves = ["x", "y", "z"].map((axis) => nodes[`displacement_${axis}`]);
    const position = this.position.array;
    const colour = this.colour.array;
    const span = high > low ? high - low : 1;
    const moved = (node, axis) => points[3 * node + axis] + scale * valueOf(moves[axis], step, node);
    const { nodes: ends, others, shares, cells } = this.faces;
    for (let i = 0; i < ends.length; i++) {
      const cell = cells[i >> 2];
      const between = (at) => (shares[i] ? at(ends[i]) + shares[i] * (at(others[i]) - at(ends[i])) : at(ends[i]));
      for (let axis = 0; axis < 3; axis++) position[3 * i + axis] = between((node) => moved(node, axis));
      position[3 * i + 2] += apart * (layer[cell] - 1);
      const value = shown.ofCells ? shown.at(step, cell) : between((node) => shown.at(step, node));
      const share = (value - low) / span;
      colour[2 * i] = (255 * Math.min(Math.max(share, 0), 1) + 0.5) / 256;
    }
    this.position.needsUpdate = this.colour.needsUpdate = true;
    this.geometry.computeBoundingBox();
    this.geometry.computeBoundingSphere();
    this.placeTools(step, scale, apart);
    this.shown = { step, field: shown };
    this.draw();
  }

  placeTools(step, scale, apart) {
    this.model.surfaces.forEach(({ name, path }, number) => {
      const shift = name === "mould" ? 0 : apart * (this.model.layers - 1);
      const at = [0, 1, 2].map((axis) => path[axis] + scale * (path[3 * step + axis] - path[axis]));
      this.tools[number].position.set(at[0], at[1], at[2] + shift);
    });
  }

  fit(side = "corner") {
    const box = this.geometry.boundingBox.clone();
    if (this.mirrored) {
      for (const { axis, at } of this.model.mirrors) {
        const ends = [box.min.getComponent(axis), box.max.getComponent(axis)];
        box.min.setComponent(axis, Math.min(...ends, ...ends.map((end) => 2 * at - end)));
        box.max.setComponent(axis, Math.max(...ends, ...ends.map((end) => 2 * at - end)));
      }
    }
    const away = new vendor.Vector3(...SIDES[side]).normalize();
    const centre = box.getCenter(this.orbit.target);
    const distance = 1.12 * distanceFor(box, away, this.camera);
    this.camera.near = 0.01 * distance;
    this.camera.far = 20 * distance;
    this.camera.updateProjectionMatrix();
    this.camera.position.copy(centre).addScaledVector(away, distance);
    this.orbit.update();
    this.draw();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /* Drawn at once, for print does not wait for the next frame. */
  theme(background, ink) {
    this.scene.background = new vendor.Color(background);
    this.ink.color = new vendor.Color(ink);
    this.render();
  }

  turn(sideways, upwards) {
    const from = this.camera.position.clone().sub(this.orbit.target);
    const place = new vendor.Spherical().setFromVector3(new vendor.Vector3(from.x, from.z, -from.y));
    place.theta -= sideways;
    place.phi = Math.min(Math.max(place.phi - upwards, 0.05), 3.09);
    const to = new vendor.Vector3().setFromSpherical(place);
    this.camera.position.copy(this.orbit.target).add(new vendor.Vector3(to.x, -to.z, to.y));
    this.orbit.update();
  }

  zoom(factor) {
    this.camera.position.sub(this.orbit.target).multiplyScalar(factor).add(this.orbit.target);
    this.orbit.update();
  }

  follow(other) {
    this.camera.position.copy(other.camera.position);
    this.orbit.target.copy(other.orbit.target);
    this.camera.lookAt(this.orbit.target);
    this.draw();
  }

  moved() {
    this.draw();
    this.onmove(this);
  }

  draw() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => this.render());
  }

  render() {
    cancelAnimationFrame(this.pending);
    this.pending = 0;
    this.lamp.position.copy(this.camera.position);
    this.renderer.render(this.scene, this.camera);
  }

  /* What lies at a place of the canvas (each coordinate from -1 to 1): cell, node nearest to it, value; or null. */
  read(x, y) {
    const ray = new vendor.Raycaster();
    ray.setFromCamera(new vendor.Vector2(x, y), this.camera);
    const hit = ray.intersectObjects(this.images.children.filter((part) => part.isMesh), false)[0];
    if (!hit) return null;
    const face = Math.floor(hit.faceIndex / 2);
    const local = hit.object.worldToLocal(hit.point.clone());
    let nearest = 4 * face;
    for (let corner = 4 * face; corner < 4 * face + 4; corner++) {
      if (this.distance(corner, local) < this.distance(nearest, local)) nearest = corner;
    }
    const { step, field: shown } = this.shown;
    const cell = this.faces.cells[face];
    const node = this.faces.shares[nearest] < 0.5 ? this.faces.nodes[nearest] : this.faces.others[nearest];
    return { cell, node, layer: this.model.layer[cell], value: shown.at(step, shown.ofCells ? cell : node) };
  }

  distance(corner, point) {
    const [x, y, z] = this.position.array.subarray(3 * corner, 3 * corner + 3);
    return Math.hypot(x - point.x, y - point.y, z - point.z);
  }
}
