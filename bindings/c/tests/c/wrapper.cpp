// Additions of palpate.hpp to palpate.h: move-only handles and exceptions.
#include <cstdio>
#include <palpate.hpp>
#include <type_traits>

static int failures = 0;
#define EXPECT(condition)                                                  \
  do {                                                                     \
    if (!(condition)) {                                                    \
      std::fprintf(stderr, "wrapper.cpp:%d: not so: %s\n", __LINE__, #condition); \
      failures++;                                                          \
    }                                                                      \
  } while (false)

static_assert(std::is_nothrow_move_constructible_v<palpate::Contact>);
static_assert(!std::is_copy_constructible_v<palpate::Contact>);
static_assert(noexcept(std::declval<palpate::Contact &>().step(0.0)));
static_assert(std::is_nothrow_move_constructible_v<palpate::ContactF32>);
static_assert(std::is_same_v<decltype(std::declval<palpate::ContactF32 &>().step(0.0f)), float>);

static_assert(std::is_nothrow_move_constructible_v<palpate::World>);
static_assert(!std::is_copy_constructible_v<palpate::World>);

/* A tool above a floor, read from a file. */
static void worlds(const char *path) {
  palpate::World first(path);
  EXPECT(first.device_count() == 1 && first.device_name(0) == "tool" && first.body_name(9).empty());
  EXPECT(first.period() == 0.001);
  palpate_pose pose = {{-0.0265, 0.003, 0.01}, {1.0, 0.0, 0.0, 0.0}};
  palpate_wrench wrench;
  EXPECT(first.step(pose, wrench) == PALPATE_FAULT_NONE && wrench.force[0] == 0.0);
  palpate::World second(std::move(first));
  wrench.force[0] = 1.0;
  EXPECT(first.step(pose, wrench) == PALPATE_FAULT_ARGUMENT);
  for (int tick = 0; tick < 400; tick++) {
    pose.position[0] = -0.0265 + 5e-5 * tick;
    EXPECT(second.step(pose, wrench) == PALPATE_FAULT_NONE);
  }
  EXPECT(wrench.force[0] < -0.01 && second.body(0).pose.position[0] > 0.005);
  EXPECT(second.ledger().dissipated > 0.0);
  try {
    second.body(9);
    EXPECT(!"there is no such body");
  } catch (const palpate::Error &error) {
    EXPECT(error.status() == PALPATE_STATUS_COUNT);
  }
  try {
    palpate::World none("none.toml");
    EXPECT(!"there is no such file");
  } catch (const palpate::Error &error) {
    EXPECT(error.status() == PALPATE_STATUS_SCENE);
  }
}

static_assert(std::is_nothrow_move_constructible_v<palpate::Scene> && !std::is_copy_constructible_v<palpate::Scene>);

template <typename Call>
static palpate_status refused(Call call) {
  try {
    call();
  } catch (const palpate::Error &error) {
    return error.status();
  }
  return PALPATE_STATUS_OK;
}

/* A world that is built by calls and changed while it runs. */
static void built() {
  palpate::Scene empty(0.001);
  auto device = palpate_device_params_default();
  for (double &mass : device.mass) mass = 0.15;
  auto block = palpate_body_params_default(), table = block;
  block.mass = 0.05;
  block.force[2] = -0.4905;
  block.pose.position[2] = 0.01;
  empty.add_device("finger", device, palpate::sphere(0.005));
  empty.add_body("table", table, palpate::half_space(0, 0, 1));
  empty.set_law("*", "*", palpate::contact_law(4000.0, 4.0, 0.4));
  palpate::Scene scene(std::move(empty));
  EXPECT(empty.handle() == nullptr && refused([&] { empty.remove_body("table"); }) == PALPATE_STATUS_NULL);
  palpate::World world(scene);
  palpate_pose pose = {{-0.03, 0.003, 0.01}, {1.0, 0.0, 0.0, 0.0}};
  palpate_wrench wrench;
  EXPECT(world.step(pose, wrench) == PALPATE_FAULT_NONE && world.body_count() == 1);
  const std::vector<double> corners = {-.02, -.02, -.01, .02, -.02, -.01, -.02, .02, -.01, .02, .02, -.01,
                                       -.02, -.02, .01,  .02, -.02, .01,  -.02, .02, .01,  .02, .02, .01};
  scene.add_body("block", block, palpate::hull(corners));
  world.change(scene);
  EXPECT(world.body_named("block") == 1 && world.body_name(1) == "block" && world.contact_count() > 0);
  for (int tick = 0; tick < 200; tick++) {
    pose.position[0] = -0.03 + 1e-4 * tick;
    EXPECT(world.step(pose, wrench) == PALPATE_FAULT_NONE);
  }
  EXPECT(world.body(1).pose.position[0] > 0.001 && world.device(0).pose.position[0] > -0.02);
  bool touches = false;
  for (std::size_t contact = 0; contact < world.contact_count(); contact++) {
    touches |= world.contact(contact).touch != PALPATE_TOUCH_FREE;
  }
  EXPECT(touches);
  auto lighter = scene.body("block");
  EXPECT(lighter.mass == 0.05);
  lighter.mass = 0.02;
  scene.set_body("block", lighter);
  scene.set_body("block", lighter, palpate::box(0.02, 0.02, 0.01));
  auto hinge = palpate_joint_params_default();
  EXPECT(refused([&] { scene.add_joint("block", hinge); }) == PALPATE_STATUS_PARAMETER);
  hinge.stiffness = 1e4;
  hinge.span = 0.02;
  scene.add_joint("block", "table", hinge);
  hinge.along_damping = 1e-3;
  scene.set_joint(0, hinge);
  EXPECT(scene.joint_count() == 1 && scene.law("*", "*").friction == 0.4);
  world.change(scene);
  scene.remove_joint(0);
  scene.set_law("finger", "block", palpate::contact_law(100.0));
  scene.remove_law("block", "finger");
  auto state = world.body(1);
  state.pose.position[0] = 0.1;
  world.place(1, state);
  EXPECT(world.body(1).pose.position[0] == 0.1);
  EXPECT(refused([&] { world.place(9, state); }) == PALPATE_STATUS_COUNT);
  EXPECT(refused([&] { world.body_named("nobody"); }) == PALPATE_STATUS_SCENE);
  scene.remove_body("block");
  world.change(scene);
  EXPECT(world.step(pose, wrench) == PALPATE_FAULT_NONE && world.body_count() == 1);
  EXPECT(refused([&] { world.change(palpate::Scene(0.002)); }) == PALPATE_STATUS_CHANGE);
  const std::uint32_t faces[] = {0, 1, 2};
  const double points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  table.pose.position[2] = -1.0;
  scene.add_body("sheet", table, palpate::mesh(points, faces));
  EXPECT(scene.body_count() == 2 && scene.device_count() == 1);
}

static void recordings(const std::string &folder) {
  auto params = palpate::contact_params(1000.0);
  params.method = "basic";
  palpate::Contact contact(params, palpate::loop_params(0.001));
  palpate::Recorder first(contact, folder + "/wrapper.mcap");
  palpate::Recorder recorder(std::move(first));
  const auto sample = palpate_sample_at(0.001);
  auto output = palpate_output_empty();
  const double force = contact.step(sample, output);
  EXPECT(first.tick(contact, sample, output, force) == PALPATE_STATUS_NULL);
  EXPECT(recorder.tick(contact, sample, output, force) == PALPATE_STATUS_OK);
  const auto recorded = recorder.close();
  EXPECT(recorded.ticks == 1 && recorded.ticks_made == 1 && recorded.lost == 0);
  EXPECT(recorder.close().ticks_made == 0);
  try {
    palpate::Recorder again(contact, folder + "/wrapper.mcap");
    EXPECT(!"a file was replaced");
  } catch (const palpate::Error &error) {
    EXPECT(error.status() == PALPATE_STATUS_RECORDING);
  }
}

/* A slope cannot be lost: a type for each hold, and no tick of a line without its output. */
static void lines(const char *folder) {
  auto params = palpate::contact_params(1000.0);
  params.method = "coupled";
  auto loop = palpate::loop_params(0.001);
  loop.device_mass = 0.25;
  const auto constant = loop;
  loop.hold = PALPATE_HOLD_LINE;
  palpate::LineContact contact(params, loop);
  double slope = 0.0;
  for (int tick = 0; tick < 20; tick++) {
    auto output = palpate_output_empty();
    const double force = contact.step(palpate_sample_at(1e-4 * tick), output);
    EXPECT(force == output.force_on_device);
    slope = output.slope_on_device;
  }
  EXPECT(slope < -50.0);
  if (folder != nullptr) {
    palpate::Recorder recorder(contact, std::string(folder) + "/line.mcap");
    auto output = palpate_output_empty();
    const auto sample = palpate_sample_at(2e-3);
    const double force = contact.step(sample, output);
    EXPECT(recorder.tick(contact, sample, output, force, output.slope_on_device) == PALPATE_STATUS_OK);
    EXPECT(recorder.close().ticks == 1);
  }
  const auto words = [](auto make) -> std::string {
    try {
      make();
      return "accepted";
    } catch (const palpate::Error &error) {
      return error.what();
    }
  };
  const std::string line = "hold is PALPATE_HOLD_LINE: use LineContact, whose output has the slope";
  EXPECT(words([&] { palpate::Contact(params, loop); }) == line);
  EXPECT(words([&] { palpate::ContactF32(params, loop); }) == line);
  EXPECT(words([&] { contact.change(params, constant); }).find("use Contact") != std::string::npos);
  EXPECT(words([&] { palpate::LineContactF32(params, loop); }) == "accepted");
}

static void low_rate_simulators() {
  auto params = palpate_local_params_default();
  try {
    palpate::local_world(params);
    EXPECT(!"a loop without a period was made");
  } catch (const palpate::Error &error) {
    EXPECT(error.status() == PALPATE_STATUS_PARAMETER);
  }
  params.period = 0.001;
  params.soft_start = 0.0;
  params.device_mass[0] = params.device_mass[1] = params.device_mass[2] = 0.2;
  params.bodies = 1;
  auto ends = palpate::local_world(params);
  palpate::LocalWorld world(std::move(ends.first));
  palpate::LowRateSimulator host(std::move(ends.second));
  const double point[3] = {0.0, 0.0, 0.0}, up[3] = {0.0, 0.0, 1.0};
  const palpate_host_body fixed = palpate_host_body_fixed(0.0, 0.0, 0.0);
  const palpate_host_contact floor = palpate_host_contact_at_gap(point, 0.0, 0, 0.0, up, 1000.0);
  palpate_body_progress given;
  palpate_wrench wrench;
  for (int tick = 0; tick < 200; tick++) {
    const auto progress = host.progress(palpate::span<palpate_body_progress>(&given, 1));
    host.publish(progress.tick, palpate::span<const palpate_host_body>(&fixed, 1),
                 palpate::span<const palpate_host_contact>(&floor, 1));
    EXPECT(world.step({{0.0, 0.0, -0.001}, {1.0, 0.0, 0.0, 0.0}}, wrench) == PALPATE_FAULT_NONE);
  }
  EXPECT(wrench.force[2] > 0.9 && wrench.force[2] < 1.1 && given.impulse[2] < -0.05);
  world.report_sent(wrench);
  EXPECT(ends.first.step({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, wrench) == PALPATE_FAULT_ARGUMENT);
  EXPECT(wrench.force[2] == 0.0);
  try {
    host.publish(0, {}, {});
    EXPECT(!"a model without its body was taken");
  } catch (const palpate::Error &error) {
    EXPECT(error.what() == std::string("body_count is 0, but the local model has 1 bodies"));
  }
}

int main(int argc, char **argv) {
  low_rate_simulators();
  if (argc > 1) worlds(argv[1]);
  built();
  if (argc > 2) recordings(argv[2]);
  auto loop = palpate::loop_params(0.001);
  auto params = palpate::contact_params(1000.0);
  params.method = "basic";
  palpate::Contact first(params, loop);
  EXPECT(first.description() == "a wall of 1000 N/m, f_V 0 N, by basic");
  EXPECT(first.step(0.001) == -1.0);

  palpate::Contact second(std::move(first));
  EXPECT(first.handle() == nullptr && first.step(0.001) == 0.0);
  EXPECT(second.step(0.001) == -1.0);
  first = std::move(second);
  EXPECT(first.step(0.002) == -2.0);
  EXPECT(first.ledger().port_work == 1.0 * 0.001);

  params.stiffness = 2000.0;
  first.change(params, loop);
  EXPECT(first.step(0.002) < -2.0);
  params.stiffness = -1.0;
  try {
    first.change(params, loop);
    EXPECT(!"a negative stiffness was taken");
  } catch (const palpate::Error &error) {
    EXPECT(error.status() == PALPATE_STATUS_PARAMETER);
    EXPECT(error.what() == std::string("stiffness is -1 N/m, but must be finite and greater than 0"));
  }
  try {
    palpate::Contact none(params, loop);
    EXPECT(!"a negative stiffness was taken");
  } catch (const std::runtime_error &) {
  }
  params.stiffness = 1000.0;
  palpate::ContactF32 in_float(params, loop);
  EXPECT(in_float.step(0.001f) == -(1000.0f * 0.001f));
  palpate::ContactF32 moved(std::move(in_float));
  EXPECT(in_float.step(0.001f) == 0.0f && moved.step(0.002f) == -(1000.0f * 0.002f));
  EXPECT(moved.ledger().port_work == (1000.0f * 0.001f) * 0.001f);
  EXPECT(moved.description() == "a wall of 1000 N/m, f_V 0 N, by basic");
  lines(argc > 2 ? argv[2] : nullptr);
  const auto names = palpate::method_names();
  EXPECT(names.front() == "basic" && names.back() == "coupled");
  const auto of_worlds = palpate::world_method_names();
  EXPECT(of_worlds.size() == 11 && of_worlds[9] == "god-object");
  EXPECT(palpate::name(PALPATE_STATUS_SCENE) == std::string("scene"));
  EXPECT(palpate::name(PALPATE_FAULT_OVERFLOW) == std::string("overflow"));
  EXPECT(first.report_sent(NAN) == PALPATE_STATUS_PARAMETER && first.report_held(0.0) == PALPATE_STATUS_OK);
  return failures != 0;
}
