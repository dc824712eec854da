export {
  AmbientLight, BackSide, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, Color, CylinderGeometry, DirectionalLight, EdgesGeometry, FrontSide,
  GreaterDepth, GridHelper, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, Plane, PlaneGeometry, Quaternion,
  Raycaster, Scene, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
