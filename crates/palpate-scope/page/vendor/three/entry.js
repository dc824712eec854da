export {
  AmbientLight, ArrowHelper, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, Color, CylinderGeometry, DirectionalLight, EdgesGeometry,
  GridHelper, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, Plane, PlaneGeometry, Quaternion,
  Raycaster, Scene, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
