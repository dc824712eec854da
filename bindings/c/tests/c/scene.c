/* Worlds that are built and changed by calls: SCENE, pushed-block.toml. Tests bit equality with the file, the state
   that a change preserves, and rejected calls. */
#include <palpate.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;
#define EXPECT(condition)                                                  \
  do {                                                                     \
    if (!(condition)) {                                                    \
      fprintf(stderr, "scene.c:%d: not so: %s (last error: %s)\n", __LINE__, #condition, palpate_last_error()); \
      failures++;                                                          \
    }                                                                      \
  } while (0)
#define OK(call) EXPECT((call) == PALPATE_STATUS_OK)
#define REFUSED(call, expected, words)                              \
  do {                                                              \
    EXPECT((call) == PALPATE_STATUS_##expected);                    \
    EXPECT(strstr(palpate_last_error(), words) != NULL);            \
  } while (0)

static palpate_scene *built_with(palpate_hold hold) {
  palpate_scene_params params = palpate_scene_params_default();
  palpate_device_params device = palpate_device_params_default();
  palpate_body_params block = palpate_body_params_default(), table = block;
  palpate_shape ball = palpate_shape_default(), box = ball, plane = ball;
  palpate_contact_law law = palpate_contact_law_default();
  palpate_scene *scene;
  params.period = 0.001, params.hold = hold;
  device.mass[0] = 0.15, device.mass[1] = 0.24, device.mass[2] = 0.375;
  for (int axis = 0; axis < 3; axis++) device.quantum[axis] = 2e-6;
  ball.radius = 0.005;
  block.mass = 0.05, block.force[2] = -0.4905, block.pose.position[2] = 0.0099386875;
  box.kind = PALPATE_SHAPE_KIND_BOX;
  box.half_extents[0] = box.half_extents[1] = 0.02, box.half_extents[2] = 0.01;
  plane.kind = PALPATE_SHAPE_KIND_HALF_SPACE;
  plane.normal[2] = 2.0; /* of any length */
  OK(palpate_scene_new(&params, &scene));
  OK(palpate_scene_add_device(scene, "tool", &device, &ball));
  OK(palpate_scene_add_body(scene, "block", &block, &box));
  OK(palpate_scene_add_body(scene, "table", &table, &plane));
  law.stiffness = 4000.0, law.damping = 2.0, law.friction = 0.4, law.friction_stiffness = 2000.0;
  OK(palpate_scene_set_law(scene, "tool", "block", &law));
  law.stiffness = 8000.0, law.damping = 8.0, law.friction_stiffness = 4000.0;
  OK(palpate_scene_set_law(scene, "block", "table", &law));
  EXPECT(palpate_scene_device_count(scene) == 1 && palpate_scene_body_count(scene) == 2);
  return scene;
}

static palpate_scene *built(void) { return built_with(PALPATE_HOLD_CONSTANT); }

static palpate_fault pushed(palpate_world *world, int tick, palpate_wrench *wrench) {
  palpate_pose pose = {{-0.0265 + 5e-5 * tick, 0.003, 0.01}, {1.0, 0.0, 0.0, 0.0}};
  palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
  return palpate_world_step(world, &sample, wrench, 1, NULL);
}

static void same_as_the_file(const char *path) {
  palpate_scene *scene = built(), *opened;
  palpate_world *from_calls, *from_file, *from_scene;
  palpate_wrench one, other, third;
  int forces = 0;
  OK(palpate_scene_open(path, &opened));
  OK(palpate_world_of_scene(scene, NULL, &from_calls));
  OK(palpate_world_open(path, NULL, &from_file));
  OK(palpate_world_of_scene(opened, NULL, &from_scene));
  palpate_scene_free(scene);
  palpate_scene_free(opened);
  for (int tick = 0; tick < 400; tick++) {
    EXPECT(pushed(from_calls, tick, &one) == PALPATE_FAULT_NONE);
    EXPECT(pushed(from_file, tick, &other) == PALPATE_FAULT_NONE);
    EXPECT(pushed(from_scene, tick, &third) == PALPATE_FAULT_NONE);
    EXPECT(memcmp(&one, &other, sizeof one) == 0 && memcmp(&third, &other, sizeof one) == 0);
    forces += one.force[0] != 0.0;
  }
  EXPECT(forces > 100);
  palpate_world_free(from_calls);
  palpate_world_free(from_file);
  palpate_world_free(from_scene);
}

/* A ball appears, rolls, is moved and is removed, beside a block that is pushed. */
static void changed(void) {
  palpate_scene *scene = built();
  palpate_world *world, *left_alone;
  palpate_body_params ball = palpate_body_params_default();
  palpate_shape sphere = palpate_shape_default();
  palpate_body_state state = palpate_body_state_empty(), block = state;
  palpate_world_ledger ledger = palpate_world_ledger_empty(), before = ledger;
  palpate_wrench wrench, alone;
  size_t place = 99;
  sphere.radius = 0.01;
  ball.mass = 0.02, ball.pose.position[1] = 1.0, ball.velocity[1] = 0.5;
  OK(palpate_world_of_scene(scene, NULL, &world));
  OK(palpate_world_of_scene(scene, NULL, &left_alone));
  for (int tick = 0; tick < 400; tick++) {
    if (tick == 100) {
      const char *name = palpate_world_body_name(world, 0);
      EXPECT(strcmp(name, "block") == 0);
      OK(palpate_scene_add_body(scene, "ball", &ball, &sphere));
      OK(palpate_world_ledger_of(world, &before));
      OK(palpate_world_change(world, scene));
      OK(palpate_world_ledger_of(world, &ledger));
      EXPECT(palpate_world_body_count(world) == 3);
      OK(palpate_world_body_named(world, "ball", &place));
      EXPECT(place == 2);
      EXPECT(fabs(ledger.kinetic - before.kinetic - 0.5 * 0.02 * 0.25) < 1e-12);
      EXPECT(ledger.created == before.created);
    }
    if (tick == 200) {
      OK(palpate_world_body_state(world, place, &state));
      EXPECT(fabs(state.pose.position[1] - 1.05) < 1e-9);
      state.pose.position[1] = 2.0;
      OK(palpate_world_place(world, place, &state));
    }
    if (tick == 300) {
      OK(palpate_world_body_state(world, place, &state));
      EXPECT(fabs(state.pose.position[1] - 2.05) < 1e-9);
      OK(palpate_scene_remove_body(scene, "ball"));
      OK(palpate_world_change(world, scene));
      REFUSED(palpate_world_body_named(world, "ball", &place), SCENE, "must be a body of the world");
    }
    EXPECT(pushed(world, tick, &wrench) == PALPATE_FAULT_NONE);
    EXPECT(pushed(left_alone, tick, &alone) == PALPATE_FAULT_NONE);
    /* Bit-identical until a body is moved: then the force changes within three samples. */
    EXPECT(fabs(wrench.force[0] - alone.force[0]) <= (tick < 200 ? 0.0 : 0.2));
  }
  EXPECT(wrench.force[0] < -0.01);
  OK(palpate_world_body_state(world, 0, &block));
  EXPECT(block.pose.position[0] > 0.005);
  palpate_world_free(left_alone);
  palpate_world_free(world);
  palpate_scene_free(scene);
}

/* The law between tool and block softens under the finger: the force changes without a step. */
static void softer(void) {
  palpate_scene *scene = built();
  palpate_world *world;
  palpate_contact_law law = palpate_contact_law_default();
  palpate_contact_state contact = palpate_contact_state_empty();
  palpate_device_state tool = palpate_device_state_empty();
  palpate_body_params block = palpate_body_params_default();
  palpate_wrench wrench;
  double before;
  int touches = 0;
  OK(palpate_scene_body(scene, "block", &block));
  EXPECT(block.mass == 0.05 && block.force[2] == -0.4905);
  block.mass = INFINITY; /* held */
  OK(palpate_scene_set_body(scene, "block", &block, NULL));
  OK(palpate_world_of_scene(scene, NULL, &world));
  for (int tick = 0; tick < 300; tick++) pushed(world, tick < 110 ? tick : 110, &wrench);
  before = wrench.force[0];
  EXPECT(fabs(before + 4000.0 * 0.0040) < 1.0);
  for (size_t at = 0; at < palpate_world_contact_count(world); at++) {
    OK(palpate_world_contact_state(world, at, &contact));
    if (contact.touch == PALPATE_TOUCH_FREE) continue;
    touches++;
    EXPECT((contact.first_device == 0 && contact.second_body == 0) || (contact.second_device == 0 && contact.first_body == 0));
    EXPECT(fabs(contact.force[0]) > 1.0 && contact.penetration > 0.001);
  }
  EXPECT(touches == 1);
  OK(palpate_world_device_state(world, 0, &tool));
  EXPECT(fabs(tool.pose.position[0] + 0.021) < 1e-4);
  OK(palpate_scene_law(scene, "block", "tool", &law));
  EXPECT(law.stiffness == 4000.0 && law.friction_stiffness == 2000.0);
  law.stiffness = 400.0;
  OK(palpate_scene_set_law(scene, "block", "tool", &law));
  OK(palpate_world_change(world, scene));
  for (int tick = 0; tick < 300; tick++) {
    pushed(world, 110, &wrench);
    EXPECT(fabs(wrench.force[0] - before) < 0.5);
    before = wrench.force[0];
  }
  EXPECT(fabs(before + 400.0 * 0.0040) < 0.1);
  palpate_world_free(world);
  palpate_scene_free(scene);
}

static const double corners[] = {-0.01, -0.01, -0.01, 0.01, -0.01, -0.01, -0.01, 0.01, -0.01, 0.01, 0.01, -0.01,
                                 -0.01, -0.01, 0.01,  0.01, -0.01, 0.01,  -0.01, 0.01, 0.01,  0.01, 0.01, 0.01};
static const uint32_t sides[] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

/* Every shape, and a joint that is changed. */
static void shapes_and_joints(void) {
  palpate_scene *scene = built();
  palpate_world *world;
  palpate_body_params body = palpate_body_params_default();
  palpate_joint_params hinge = palpate_joint_params_default();
  palpate_body_state state = palpate_body_state_empty();
  palpate_wrench wrench;
  size_t place = 0;
  double corners_of_mine[sizeof corners / sizeof *corners];
  memcpy(corners_of_mine, corners, sizeof corners);
  for (uint32_t kind = PALPATE_SHAPE_KIND_SPHERE; kind <= PALPATE_SHAPE_KIND_HULL; kind++) {
    palpate_shape shape = palpate_shape_default();
    char name[] = "shape 0";
    name[6] = (char)('0' + kind);
    shape.kind = kind;
    shape.radius = 0.01, shape.half_length = 0.01;
    for (int axis = 0; axis < 3; axis++) shape.half_extents[axis] = 0.01;
    shape.points = corners_of_mine, shape.point_count = 8;
    shape.faces = sides, shape.face_count = 12;
    body.mass = kind == PALPATE_SHAPE_KIND_HALF_SPACE ? INFINITY : 0.1;
    body.pose.position[2] = 1.0 + kind;
    OK(palpate_scene_add_body(scene, name, &body, &shape));
  }
  memset(corners_of_mine, 0, sizeof corners_of_mine); /* they were copied */
  /* A mesh that hangs on a hinge falls and swings; a slider then holds it. */
  OK(palpate_scene_body(scene, "shape 5", &body));
  body.force[2] = -0.981;
  OK(palpate_scene_set_body(scene, "shape 5", &body, NULL));
  hinge.axis[1] = 3.0, hinge.axis[2] = 0.0, hinge.stiffness = 1e4, hinge.span = 0.03;
  hinge.point[0] = -0.05, hinge.point[2] = body.pose.position[2];
  OK(palpate_scene_add_joint(scene, "shape 5", NULL, &hinge));
  EXPECT(palpate_scene_joint_count(scene) == 1);
  OK(palpate_world_of_scene(scene, NULL, &world));
  OK(palpate_world_body_named(world, "shape 5", &place));
  for (int tick = 0; tick < 100; tick++) pushed(world, 0, &wrench);
  OK(palpate_world_body_state(world, place, &state));
  {
    const double x = state.pose.position[0] + 0.05, z = state.pose.position[2] - hinge.point[2];
    EXPECT(fabs(sqrt(x * x + z * z) - 0.05) < 1e-3 && z < -0.02);
  }
  hinge.along_damping = 0.005; /* the same bearing keeps its position */
  OK(palpate_scene_set_joint(scene, 0, &hinge));
  OK(palpate_world_change(world, scene));
  for (int tick = 0; tick < 1000; tick++) pushed(world, 0, &wrench);
  OK(palpate_world_body_state(world, place, &state));
  EXPECT(fabs(state.pose.position[0] + 0.05) < 2e-3 && fabs(state.velocity[0]) < 0.02);
  OK(palpate_scene_remove_joint(scene, 0));
  OK(palpate_world_change(world, scene));
  for (int tick = 0; tick < 100; tick++) pushed(world, 0, &wrench);
  {
    const double z = state.pose.position[2];
    OK(palpate_world_body_state(world, place, &state));
    EXPECT(state.pose.position[2] < z - 0.04);
  }
  palpate_world_free(world);
  palpate_scene_free(scene);
}

static void misuse(void) {
  palpate_scene *scene = built(), *none = scene;
  palpate_world *world = NULL;
  palpate_scene_params params = palpate_scene_params_default();
  palpate_device_params device = palpate_device_params_default();
  palpate_body_params body = palpate_body_params_default();
  palpate_shape shape = palpate_shape_default();
  palpate_contact_law law = palpate_contact_law_default();
  palpate_joint_params joint = palpate_joint_params_default();
  palpate_body_state state = palpate_body_state_empty();
  palpate_contact_state contact = palpate_contact_state_empty();
  palpate_device_state tool = palpate_device_state_empty();
  palpate_wrench wrench;
  size_t place = 7;

  REFUSED(palpate_scene_new(&params, &none), PARAMETER, "period is 0, but must be finite and greater than 0");
  EXPECT(none == NULL);
  REFUSED(palpate_scene_new(NULL, &none), NULL, "palpate_scene_params is NULL");
  REFUSED(palpate_scene_new(&params, NULL), NULL, "scene is NULL");
  params.struct_size = 8;
  REFUSED(palpate_scene_new(&params, &none), STRUCT_SIZE, "palpate_scene_params is 8");
  REFUSED(palpate_scene_open("none.toml", &none), SCENE, "none.toml");
  REFUSED(palpate_scene_open("", &none), SCENE, "path is \"\", but must name a file");
  params = palpate_scene_params_default();
  params.period = 0.001;
  OK(palpate_scene_new(&params, &none));
  REFUSED(palpate_world_of_scene(none, NULL, &world), SCENE, "there is no tool");
  EXPECT(world == NULL);
  palpate_scene_free(none);

  REFUSED(palpate_scene_add_device(scene, "second", &device, &shape), PARAMETER, "mass is 0");
  for (int axis = 0; axis < 3; axis++) device.mass[axis] = 0.1;
  REFUSED(palpate_scene_add_device(scene, "block", &device, &shape), SCENE, "already has");
  REFUSED(palpate_scene_add_device(scene, "left,right", &device, &shape), SCENE, "must have no comma");
  shape.kind = PALPATE_SHAPE_KIND_HALF_SPACE, shape.normal[2] = 1.0, shape.radius = 0.01;
  REFUSED(palpate_scene_add_device(scene, "second", &device, &shape), PARAMETER, "a tool has to be a sphere");
  EXPECT(palpate_scene_device_count(scene) == 1);
  shape.kind = PALPATE_SHAPE_KIND_SPHERE;
  device.reserved = 1;
  REFUSED(palpate_scene_add_device(scene, "second", &device, &shape), PARAMETER, "reserved is 1, but must be 0");
  device.reserved = 0, device.turns = 3;
  REFUSED(palpate_scene_add_device(scene, "second", &device, &shape), PARAMETER, "turns is 3, but must be 0, 1 or 2");
  device.turns = 1;
  REFUSED(palpate_scene_add_device(scene, "second", &device, &shape), PARAMETER, "inertia is 0");
  device.turns = 3;
  REFUSED(palpate_scene_add_device(scene, "second", &device, &shape), PARAMETER, "turns is 3, but must be 0, 1 or 2");

  REFUSED(palpate_scene_add_body(scene, "*", &body, &shape), SCENE, "must be a name");
  REFUSED(palpate_scene_add_body(scene, "world", &body, &shape), SCENE, "must be a name");
  REFUSED(palpate_scene_add_body(scene, NULL, &body, &shape), NULL, "name is NULL");
  REFUSED(palpate_scene_add_body(scene, "block", &body, &shape), SCENE, "already has");
  shape.kind = 8;
  REFUSED(palpate_scene_add_body(scene, "new", &body, &shape), PARAMETER, "kind is 8");
  shape.kind = PALPATE_SHAPE_KIND_MESH;
  REFUSED(palpate_scene_add_body(scene, "new", &body, &shape), PARAMETER, "");
  shape.points = corners, shape.point_count = 8, shape.face_count = 2;
  REFUSED(palpate_scene_add_body(scene, "new", &body, &shape), NULL, "faces is NULL");
  shape.face_count = SIZE_MAX, shape.faces = sides;
  REFUSED(palpate_scene_add_body(scene, "new", &body, &shape), MEMORY, "not an array");
  shape.kind = PALPATE_SHAPE_KIND_SPHERE, shape.radius = -1.0;
  REFUSED(palpate_scene_add_body(scene, "new", &body, &shape), PARAMETER, "radius is -1");
  shape.reserved = 1;
  REFUSED(palpate_scene_add_body(scene, "new", &body, &shape), PARAMETER, "reserved is 1, but must be 0");
  shape.reserved = 0;
  shape.radius = 0.01, body.mass = NAN;
  REFUSED(palpate_scene_add_body(scene, "new", &body, &shape), PARAMETER, "mass is NaN");
  EXPECT(palpate_scene_body_count(scene) == 2);
  body.mass = -1.0;
  REFUSED(palpate_scene_set_body(scene, "block", &body, NULL), PARAMETER, "mass is -1");
  OK(palpate_scene_body(scene, "block", &body));
  EXPECT(body.mass == 0.05);
  /* A fixed body would silently ignore its velocity. */
  body.mass = INFINITY, body.velocity[0] = 1.0;
  REFUSED(palpate_scene_set_body(scene, "block", &body, NULL), PARAMETER, "velocity is [1.0, 0.0, 0.0], but a fixed body");
  body.velocity[0] = 0.0, body.angular_velocity[2] = 1.0, shape.radius = 0.01;
  REFUSED(palpate_scene_add_body(scene, "new", &body, &shape), PARAMETER, "angular_velocity is [0.0, 0.0, 1.0]");
  OK(palpate_scene_body(scene, "block", &body));
  EXPECT(body.mass == 0.05);
  REFUSED(palpate_scene_body(scene, "nobody", &body), SCENE, "a body of the scene: block, table");
  REFUSED(palpate_scene_remove_body(scene, "tool"), SCENE, "a body of the scene");

  REFUSED(palpate_scene_set_law(scene, "tool", "block", &law), PARAMETER, "stiffness is 0");
  law.stiffness = 100.0;
  REFUSED(palpate_scene_set_law(scene, "tool", "nobody", &law), SCENE, "neither a tool nor a body");
  REFUSED(palpate_scene_set_law(scene, "block", "block", &law), SCENE, "cannot touch itself");
  REFUSED(palpate_scene_remove_law(scene, "tool", "table"), SCENE, "no law between \"tool\" and \"table\"");
  OK(palpate_scene_law(scene, "tool", "block", &law));
  EXPECT(law.stiffness == 4000.0);

  REFUSED(palpate_scene_add_joint(scene, "table", NULL, &joint), SCENE, "has to be a body that moves");
  joint.kind = 7;
  REFUSED(palpate_scene_add_joint(scene, "block", NULL, &joint), PARAMETER, "kind is 7");
  joint.kind = PALPATE_JOINT_SLIDER;
  REFUSED(palpate_scene_add_joint(scene, "block", "table", &joint), PARAMETER, "stiffness is 0");
  joint.has_limits = 2;
  REFUSED(palpate_scene_add_joint(scene, "block", "table", &joint), PARAMETER, "has_limits is 2, but must be 0 or 1");
  REFUSED(palpate_scene_set_joint(scene, 0, &joint), COUNT, "joint is 0");
  REFUSED(palpate_scene_remove_joint(scene, 3), COUNT, "joint is 3");

  OK(palpate_world_of_scene(scene, NULL, &world));
  for (int tick = 0; tick < 50; tick++) pushed(world, tick, &wrench);
  state.pose.position[0] = NAN;
  REFUSED(palpate_world_place(world, 0, &state), PARAMETER, "position");
  state.pose.position[0] = 0.0, state.velocity[0] = 1.0;
  REFUSED(palpate_world_place(world, 1, &state), CHANGE, "a fixed body has no velocity");
  REFUSED(palpate_world_place(world, 2, &state), COUNT, "body is 2");
  REFUSED(palpate_world_place(world, 0, NULL), NULL, "palpate_body_state is NULL");
  REFUSED(palpate_world_contact_state(world, 999, &contact), COUNT, "contact is 999");
  REFUSED(palpate_world_device_state(world, 1, &tool), COUNT, "device is 1");
  device.turns = 0;
  OK(palpate_scene_add_device(scene, "second", &device, &shape));
  REFUSED(palpate_world_change(world, scene), CHANGE, "2 tools, previously 1");
  REFUSED(palpate_world_change(world, NULL), NULL, "scene is NULL");
  REFUSED(palpate_world_change(NULL, scene), NULL, "world is NULL");
  params.period = 0.002;
  OK(palpate_scene_new(&params, &none));
  REFUSED(palpate_world_change(world, none), CHANGE, "period is 0.002 s, but must be that of the world, 0.001 s");
  palpate_scene_free(none);
  EXPECT(palpate_world_body_count(world) == 2 && pushed(world, 50, &wrench) == PALPATE_FAULT_NONE);
  REFUSED(palpate_world_body_named(world, "block", NULL), NULL, "body is NULL");
  OK(palpate_world_body_named(world, "block", &place));
  EXPECT(place == 0);
  EXPECT(palpate_scene_body_count(NULL) == 0 && palpate_world_contact_count(NULL) == 0);
  palpate_scene_free(NULL);
  palpate_world_free(world);
  palpate_scene_free(scene);
}

/* A hand turns a pen against a wall: with turns = 1 the tool gives a torque, with 2 it does not. */
static void turned(unsigned turns) {
  palpate_scene_params params = palpate_scene_params_default();
  palpate_device_params device = palpate_device_params_default();
  palpate_body_params floor = palpate_body_params_default();
  palpate_shape pen = palpate_shape_default(), plane = pen;
  palpate_contact_law law = palpate_contact_law_default();
  palpate_scene *scene;
  palpate_world *world;
  double force = 0.0, torque = 0.0;
  params.period = 0.001;
  device.turns = turns;
  for (int axis = 0; axis < 3; axis++) device.mass[axis] = 0.1, device.inertia[axis] = 1e-4;
  pen.kind = PALPATE_SHAPE_KIND_CAPSULE, pen.radius = 0.004, pen.half_length = 0.04;
  plane.kind = PALPATE_SHAPE_KIND_HALF_SPACE, plane.normal[2] = 1.0;
  law.stiffness = law.friction_stiffness = 3000.0;
  OK(palpate_scene_new(&params, &scene));
  OK(palpate_scene_add_device(scene, "pen", &device, &pen));
  OK(palpate_scene_add_body(scene, "floor", &floor, &plane));
  OK(palpate_scene_set_law(scene, "*", "*", &law));
  OK(palpate_world_of_scene(scene, NULL, &world));
  EXPECT(palpate_world_device_turns(world, 0) == turns);
  for (int tick = 0; tick < 100; tick++) {
    double half = 0.7 - 1e-3 * tick;
    palpate_pose pose = {{0.0, 0.0, 0.011}, {cos(half), 0.0, sin(half), 0.0}};
    palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
    palpate_wrench wrench;
    EXPECT(palpate_world_step(world, &sample, &wrench, 1, NULL) == PALPATE_FAULT_NONE);
    force = fmax(force, wrench.force[2]);
    torque = fmax(torque, fabs(wrench.torque[1]));
  }
  EXPECT(force > 1.0);
  EXPECT(turns == 1 ? torque > 0.01 : torque == 0.0);
  palpate_world_free(world);
  palpate_scene_free(scene);
}

/* The guard of a scene limits the forces of its worlds, whether the scene is built or read; a bound of the hand
   lets more through. */
static void guarded(const char *path) {
  palpate_guard_params guard = palpate_guard_params_default();
  palpate_scene *scenes[3] = {built(), NULL, built()};
  palpate_world *worlds[3];
  palpate_wrench wrenches[3];
  palpate_world_output output = palpate_world_output_empty();
  int limited = 0, more = 0;
  EXPECT(guard.mode == PALPATE_GUARD_LIMIT && guard.speed == 1.0 && guard.turning_speed == 10.0);
  EXPECT(guard.allowance == 0.05 && guard.recovery == 0.02 && guard.hand_force == 0.0);
  OK(palpate_scene_open(path, &scenes[1]));
  guard.allowance = 1e-5;
  for (int at = 0; at < 3; at++) {
    if (at == 2) guard.hand_force = 8.0, guard.least_mass = 0.01;
    OK(palpate_scene_set_guard(scenes[at], &guard));
    OK(palpate_world_of_scene(scenes[at], NULL, &worlds[at]));
  }
  for (int tick = 0; tick < 400; tick++) {
    palpate_pose pose = {{-0.0265 + 5e-5 * tick, 0.003, 0.01}, {1.0, 0.0, 0.0, 0.0}};
    palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
    for (int at = 0; at < 3; at++) {
      EXPECT(palpate_world_step(worlds[at], &sample, &wrenches[at], 1, &output) == PALPATE_FAULT_NONE);
      limited += at == 0 && (output.limited & PALPATE_LIMIT_GUARD) != 0;
    }
    EXPECT(memcmp(&wrenches[0], &wrenches[1], sizeof wrenches[0]) == 0);
    more += fabs(wrenches[2].force[0]) > fabs(wrenches[0].force[0]);
  }
  EXPECT(limited > 5 && more > 5);
  guard.acceleration = 80.0;
  REFUSED(palpate_scene_set_guard(scenes[0], &guard), PARAMETER, "hand_force is 8, but must be 0 if acceleration is given");
  guard.acceleration = guard.hand_force = 0.0;
  REFUSED(palpate_scene_set_guard(scenes[0], &guard), PARAMETER, "least_mass is 0.01, but must be 0 without");
  guard.least_mass = 0.0, guard.hand_torque = 1.0;
  REFUSED(palpate_scene_set_guard(scenes[0], &guard), PARAMETER, "hand_torque is 1, but must be 0 without hand_force");
  guard.hand_torque = 0.0, guard.speed = 0.0;
  REFUSED(palpate_scene_set_guard(scenes[0], &guard), PARAMETER, "speed is 0, but must be finite and greater than 0");
  guard.speed = 1.0, guard.late_samples = 9;
  REFUSED(palpate_scene_set_guard(scenes[0], &guard), SCENE, "late_samples is 9, but must be at most 8");
  guard.late_samples = 0, guard.mode = 3;
  REFUSED(palpate_scene_set_guard(scenes[0], &guard), PARAMETER, "mode is 3, but must be PALPATE_GUARD_OFF");
  REFUSED(palpate_scene_set_guard(NULL, &guard), NULL, "scene is NULL");
  for (int at = 0; at < 3; at++) {
    palpate_world_free(worlds[at]);
    palpate_scene_free(scenes[at]);
  }
}

/* A line ends nearer to the force of the contact than a constant does. */
static void lines(void) {
  palpate_scene *scenes[2] = {built(), built_with(PALPATE_HOLD_LINE)};
  palpate_wrench wrench[2];
  palpate_world *worlds[2];
  palpate_scene_params params = palpate_scene_params_default();
  int sloped = 0;
  for (int at = 0; at < 2; at++) {
    OK(palpate_world_of_scene(scenes[at], NULL, &worlds[at]));
    palpate_scene_free(scenes[at]);
  }
  for (int tick = 0; tick < 400; tick++) {
    for (int at = 0; at < 2; at++) EXPECT(pushed(worlds[at], tick, &wrench[at]) == PALPATE_FAULT_NONE);
    EXPECT(wrench[0].slope[0] == 0.0);
    sloped += wrench[1].slope[0] < -1.0;
  }
  EXPECT(sloped > 50 && wrench[1].force[0] < 0.0);
  OK(palpate_world_report_sent(worlds[1], 0, &wrench[1]));
  wrench[1].slope[1] = NAN;
  REFUSED(palpate_world_report_sent(worlds[1], 0, &wrench[1]), PARAMETER, "slope is NaN, but must be finite [N/s]");
  params.period = 0.001, params.hold = 2;
  REFUSED(palpate_scene_new(&params, &scenes[1]), PARAMETER, "hold is 2, but must be PALPATE_HOLD_CONSTANT");
  for (int at = 0; at < 2; at++) palpate_world_free(worlds[at]);
}

/* A recorder rejects ticks of a world that was changed; a new recorder accepts them. */
static void recorded(const char *folder) {
  palpate_scene *scene = built();
  palpate_world *world;
  palpate_recorder *recorder;
  palpate_recorded sum = palpate_recorded_empty();
  palpate_world_output output = palpate_world_output_empty();
  char path[2][512];
  OK(palpate_world_of_scene(scene, NULL, &world));
  for (int part = 0; part < 2; part++) {
    snprintf(path[part], sizeof path[part], "%s/built-%d.mcap", folder, part);
    OK(palpate_recorder_of_world(world, path[part], NULL, &recorder));
    for (int tick = 0; tick < 200; tick++) {
      palpate_pose pose = {{-0.0265 + 5e-5 * tick, 0.003, 0.01}, {1.0, 0.0, 0.0, 0.0}};
      palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
      palpate_wrench wrench;
      EXPECT(palpate_world_step(world, &sample, &wrench, 1, &output) == PALPATE_FAULT_NONE);
      OK(palpate_recorder_world_tick(recorder, world, &sample, &output, &wrench));
      if (tick == 199 && part == 0) {
        OK(palpate_scene_remove_body(scene, "table"));
        OK(palpate_world_change(world, scene));
        REFUSED(palpate_recorder_world_tick(recorder, world, &sample, &output, &wrench), RECORDING, "have changed");
      }
    }
    OK(palpate_recorder_close(recorder, &sum));
    EXPECT(sum.ticks == 200 && sum.lost == 0);
  }
  palpate_world_free(world);
  palpate_scene_free(scene);
}

int main(int argc, char **argv) {
  if (argc < 3) return 2;
  same_as_the_file(argv[1]);
  changed();
  softer();
  shapes_and_joints();
  misuse();
  guarded(argv[1]);
  lines();
  turned(1);
  turned(2);
  recorded(argv[2]);
  return failures != 0;
}
