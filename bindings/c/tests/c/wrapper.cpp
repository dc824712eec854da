// What palpate.hpp adds to palpate.h: handles that move and free themselves, errors that are thrown.
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

/* A tool over a floor, from a file. */
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

static void recordings(const std::string &folder) {
  auto params = palpate::contact_params(1000.0);
  params.method = "basic";
  palpate::Contact contact(params, palpate::loop_params(0.001));
  palpate::Recorder first(contact, folder + "/wrapper.mcap");
  palpate::Recorder recorder(std::move(first));
  const auto sample = palpate_sample_at(0.001);
  auto output = palpate_output_empty();
  const double force = contact.step(sample, &output);
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

int main(int argc, char **argv) {
  if (argc > 1) worlds(argv[1]);
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
  const auto names = palpate::method_names();
  EXPECT(names.front() == "basic" && names.back() == "coupled");
  return failures != 0;
}
