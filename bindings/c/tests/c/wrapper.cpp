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

int main() {
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
  const auto names = palpate::method_names();
  EXPECT(names.front() == "basic" && names.back() == "coupled");
  return failures != 0;
}
