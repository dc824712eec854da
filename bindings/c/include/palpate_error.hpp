/*
 * Errors of palpate.h as C++17 exceptions; part of palpate.hpp.
 *
 * License: MIT OR Apache-2.0
 */
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "palpate.h"

namespace palpate {

/* An invalid parameter: what() returns its name, its value and the allowed range. */
class Error : public std::runtime_error {
 public:
  Error(palpate_status status, const std::string &words) : std::runtime_error(words), status_(status) {}

  palpate_status status() const noexcept { return status_; }

 private:
  palpate_status status_;
};

namespace detail {

inline void check(palpate_status status) {
  if (status != PALPATE_STATUS_OK) {
    throw Error(status, palpate_last_error());
  }
}

inline void check_version() {
  if (palpate_abi_version() != PALPATE_ABI_VERSION) {
    throw Error(PALPATE_STATUS_STRUCT_SIZE, "this program was compiled with another palpate.h than the library has");
  }
}

/* Throws Error if the hold of a loop is not that of the type which renders it. */
inline void check_hold(const palpate_loop_params &loop, palpate_hold hold) {
  if (hold == PALPATE_HOLD_CONSTANT && loop.hold == PALPATE_HOLD_LINE) {
    throw Error(PALPATE_STATUS_PARAMETER, "hold is PALPATE_HOLD_LINE: use LineContact, whose output has the slope");
  }
  if (hold == PALPATE_HOLD_LINE && loop.hold == PALPATE_HOLD_CONSTANT) {
    throw Error(PALPATE_STATUS_PARAMETER, "hold is PALPATE_HOLD_CONSTANT: use Contact, or set PALPATE_HOLD_LINE");
  }
}

template <typename Text>
std::string text(Text put) {
  std::string words(put(nullptr, std::size_t{0}), '\0');
  // Writing 0 to the terminator of a std::string is allowed.
  put(words.data(), words.size() + 1);
  return words;
}

}  // namespace detail

}  // namespace palpate
