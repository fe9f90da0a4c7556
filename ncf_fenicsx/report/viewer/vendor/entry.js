/* What the pages of the report take from three.js and uPlot; docs/developing.md says how vendor.js is made of it. */
import uPlot from "uplot";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DataTexture, DirectionalLight, DoubleSide, DynamicDrawUsage,
  Group, LinearFilter, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, Raycaster,
  RGBAFormat, Scene, Spherical, SRGBColorSpace, Vector2, Vector3, WebGLRenderer,
} from "three";

globalThis.vendor = {
  uPlot, OrbitControls,
  AmbientLight, BufferAttribute, BufferGeometry, Color, DataTexture, DirectionalLight, DoubleSide, DynamicDrawUsage,
  Group, LinearFilter, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, Raycaster,
  RGBAFormat, Scene, Spherical, SRGBColorSpace, Vector2, Vector3, WebGLRenderer,
};
