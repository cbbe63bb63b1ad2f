// What the viewer takes of three.js; .ci/three makes three.min.js of it.
export {
  BackSide, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, HemisphereLight, InstancedMesh, LatheGeometry,
  Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, Quaternion, Raycaster, Scene, SphereGeometry, Vector2,
  Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { toCreasedNormals } from "three/addons/utils/BufferGeometryUtils.js";
