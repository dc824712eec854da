// palpate::span: accepted and rejected types, and functions that take spans. Compiled as C++17 and as C++20.
#include <array>
#include <cstdio>
#include <palpate.hpp>
#include <string>
#include <type_traits>
#include <vector>
#if __cplusplus >= 202002L
#include <span>
#endif

static int failures = 0;
#define EXPECT(condition)                                                                    \
  do {                                                                                       \
    if (!(condition)) {                                                                      \
      std::fprintf(stderr, "span.cpp:%d: not so: %s\n", __LINE__, #condition);               \
      failures++;                                                                            \
    }                                                                                        \
  } while (false)

using palpate::span;

template <typename From, typename To>
constexpr bool takes = std::is_convertible_v<From, To>;

static_assert(std::is_trivially_copyable_v<span<int>> && sizeof(span<int>) == 2 * sizeof(void *));
static_assert(takes<int (&)[3], span<int>> && takes<int (&)[3], span<const int>>);
static_assert(takes<const int (&)[3], span<const int>> && !takes<const int (&)[3], span<int>>);
static_assert(takes<std::array<int, 3> &, span<int>> && takes<const std::array<int, 3> &, span<const int>>);
static_assert(takes<std::array<const int, 3> &, span<const int>>);
static_assert(takes<std::vector<int> &, span<int>> && takes<std::vector<int> &, span<const int>>);
// A temporary gives a read-only span.
static_assert(takes<std::vector<int>, span<const int>> && !takes<std::vector<int>, span<int>>);
static_assert(!takes<const std::vector<int> &, span<int>>);
static_assert(takes<span<int>, span<const int>> && !takes<span<const int>, span<int>>);
// A convertible type is not an element type: its array has another stride.
static_assert(!takes<std::vector<float> &, span<double>> && !takes<std::vector<int> &, span<const long>>);
struct Longer : palpate_pose {
  double more;
};
static_assert(!takes<std::vector<Longer> &, span<const palpate_pose>> && !takes<Longer (&)[2], span<palpate_pose>>);
static_assert(!takes<int *, span<int>> && !takes<int, span<int>>);
static_assert(std::is_nothrow_constructible_v<span<int>, std::vector<int> &>);
#if __cplusplus >= 202002L
static_assert(takes<std::span<int>, span<int>> && takes<std::span<int>, span<const int>>);
static_assert(takes<std::span<int, 3>, span<int>> && takes<std::span<const int>, span<const int>>);
static_assert(!takes<std::span<const int>, span<int>>);
static_assert(takes<span<int>, std::span<int>> && takes<span<int>, std::span<const int>>);
static_assert(!takes<span<const int>, std::span<int>>);
#endif

static constexpr int numbers[] = {1, 2, 3};
static_assert(span<const int>(numbers).size() == 3 && span<const int>(numbers)[2] == 3);
static_assert(span<const int>(numbers).subspan(1).first(1)[0] == 2);
static_assert(span<const int>().empty() && span<const int>().begin() == span<const int>().end());

static int sum(span<const int> of) {
  int all = 0;
  for (int one : of) all += one;
  return all;
}

static void taken() {
  int array[3] = {1, 2, 3};
  std::array<int, 2> two = {4, 5};
  std::vector<int> more = {6, 7, 8, 9};
  EXPECT(sum(array) == 6 && sum(two) == 9 && sum(more) == 30);
  EXPECT(sum({array, 2}) == 3 && sum({}) == 0 && sum(std::vector<int>{1, 1}) == 2);
  EXPECT(sum(std::vector<int>()) == 0);
  span<int> all = more;
  for (int &one : all) one = 1;
  EXPECT(sum(more) == 4 && all.data() == more.data());
  span<const int> seen = all;
  EXPECT(sum(seen.subspan(1)) == 3);
#if __cplusplus >= 202002L
  std::span<int> of_std = more;
  EXPECT(sum(of_std) == 4 && sum(of_std.first(2)) == 2);
  std::span<const int> back = seen;
  EXPECT(back.size() == 4 && back.data() == more.data());
#endif
}

/* A world of two devices: one pose per device, in any array. */
static void worlds(const char *path) {
  palpate::World world{std::string(path)};
  EXPECT(world.device_count() == 2);
  const palpate_pose left = {{-0.03, 0.0, 0.02}, {1.0, 0.0, 0.0, 0.0}};
  const palpate_pose right = {{0.03, 0.0, 0.02}, {1.0, 0.0, 0.0, 0.0}};
  const palpate_pose array[2] = {left, right};
  std::array<palpate_wrench, 2> wrenches{};
  EXPECT(world.step(array, wrenches) == PALPATE_FAULT_NONE);
  std::vector<palpate_pose> poses = {left, right};
  std::vector<palpate_wrench> given(2);
  EXPECT(world.step(poses, given) == PALPATE_FAULT_NONE);
  EXPECT(world.step({poses.data(), 2}, wrenches) == PALPATE_FAULT_NONE);
#if __cplusplus >= 202002L
  EXPECT(world.step(std::span(poses), std::span(given)) == PALPATE_FAULT_NONE);
#endif
  // A wrong number of poses or wrenches: no force, and no access beyond the arrays.
  given[0].force[0] = given[1].force[0] = 1.0;
  EXPECT(world.step(span<const palpate_pose>(poses).first(1), given) == PALPATE_FAULT_ARGUMENT);
  EXPECT(given[0].force[0] == 0.0 && given[1].force[0] == 0.0);
  EXPECT(std::string(palpate_last_error()) == "pose_count is 1, but the world has 2 devices");
  given[1].force[0] = 1.0;
  EXPECT(world.step(poses, span<palpate_wrench>(given).first(1)) == PALPATE_FAULT_ARGUMENT);
  EXPECT(given[1].force[0] == 1.0);
  poses.push_back(left);
  EXPECT(world.step(poses, given) == PALPATE_FAULT_ARGUMENT);
  EXPECT(world.step({}, {}) == PALPATE_FAULT_ARGUMENT);
  poses.pop_back();
  auto sample = palpate::world_sample(poses);
  auto output = palpate_world_output_empty();
  EXPECT(world.step(sample, given, &output) == PALPATE_FAULT_NONE && output.sub_steps > 0);
  std::vector<palpate_body_state> bodies(world.body_count());
  world.bodies(bodies);
  EXPECT(bodies[0].pose.position[2] == world.body(0).pose.position[2]);
  bodies.emplace_back();
  try {
    world.bodies(bodies);
    EXPECT(!"more states than bodies were filled");
  } catch (const palpate::Error &error) {
    EXPECT(error.status() == PALPATE_STATUS_COUNT);
  }
}

int main(int argc, char **argv) {
  taken();
  auto params = palpate::contact_params(1000.0);
  params.method = "virtual-damper";
  std::vector<palpate_setting> settings = {{"damping_n_s_per_m", 0.5, nullptr}};
  palpate::use(params, settings);
  EXPECT(params.setting_count == 1 && params.settings == settings.data());
  alignas(PALPATE_CONTACT_ALIGN_MAX) std::array<unsigned char, PALPATE_CONTACT_SIZE_MAX> memory;
  palpate::Contact placed(memory, params, palpate::loop_params(0.001));
  EXPECT(placed.step(0.001) <= -1.0);
  EXPECT(reinterpret_cast<unsigned char *>(placed.handle()) == memory.data());
  try {
    palpate::Contact none(span<unsigned char>(memory).first(16), params, palpate::loop_params(0.001));
    EXPECT(!"16 bytes were enough");
  } catch (const palpate::Error &error) {
    EXPECT(error.status() == PALPATE_STATUS_MEMORY);
  }
  if (argc > 3) worlds(argv[3]);
  return failures != 0;
}
