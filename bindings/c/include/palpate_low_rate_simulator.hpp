/*
 * Multirate local models of low-rate simulators for C++17; part of palpate.hpp. docs/integrate/c.md
 *
 * License: MIT OR Apache-2.0
 */
#pragma once

#include <cstdint>
#include <utility>

#include "palpate.h"
#include "palpate_error.hpp"
#include "palpate_span.hpp"

namespace palpate {

/* Simulator side of a local model, for the thread of a low-rate simulator such as a 60 Hz physics engine. Movable and
   not copyable; a moved-from object publishes nothing. */
class LowRateSimulator {
 public:
  explicit LowRateSimulator(palpate_low_rate_simulator *host) noexcept : host_(host) {}
  LowRateSimulator(LowRateSimulator &&other) noexcept : host_(std::exchange(other.host_, nullptr)) {}

  LowRateSimulator &operator=(LowRateSimulator &&other) noexcept {
    std::swap(host_, other.host_);
    return *this;
  }

  LowRateSimulator(const LowRateSimulator &) = delete;
  LowRateSimulator &operator=(const LowRateSimulator &) = delete;

  ~LowRateSimulator() { palpate_low_rate_simulator_free(host_); }

  /* Returns the progress of the loop and writes the impulses of the tool on each body. Throws Error for a wrong number
     of bodies. */
  palpate_progress progress(span<palpate_body_progress> bodies) {
    palpate_progress progress = palpate_progress_empty();
    detail::check(palpate_low_rate_simulator_progress(host_, &progress, bodies.data(), bodies.size()));
    return progress;
  }

  /* Publishes bodies and contacts for the tick of a progress. Throws Error with all faults and then keeps the previous
     model. */
  void publish(std::uint64_t tick, span<const palpate_host_body> bodies, span<const palpate_host_contact> contacts) {
    detail::check(
        palpate_low_rate_simulator_publish(host_, tick, bodies.data(), bodies.size(), contacts.data(), contacts.size()));
  }

  /* Returns the handle, for functions of palpate.h. */
  palpate_low_rate_simulator *handle() noexcept { return host_; }

 private:
  palpate_low_rate_simulator *host_ = nullptr;
};

/* Loop side of a local model, for the thread that samples the device: renders the published bodies and contacts.
   Movable and not copyable; a moved-from object returns no force. */
class LocalWorld {
 public:
  explicit LocalWorld(palpate_local_world *world) noexcept : world_(world) {}
  LocalWorld(LocalWorld &&other) noexcept : world_(std::exchange(other.world_, nullptr)) {}

  LocalWorld &operator=(LocalWorld &&other) noexcept {
    std::swap(world_, other.world_);
    return *this;
  }

  LocalWorld(const LocalWorld &) = delete;
  LocalWorld &operator=(const LocalWorld &) = delete;

  ~LocalWorld() { palpate_local_world_free(world_); }

  /* Executes one tick: reads the device pose and writes the wrench to hold. Returns the reason if the wrench is 0. */
  palpate_fault step(const palpate_pose &pose, palpate_wrench &wrench, palpate_local_output *output = nullptr) noexcept {
    return step(palpate_world_sample_at(&pose, 1), wrench, output);
  }

  /* Executes one tick with a full sample. */
  palpate_fault step(const palpate_world_sample &sample, palpate_wrench &wrench, palpate_local_output *output) noexcept {
    return palpate_local_world_step(world_, &sample, &wrench, output);
  }

  /* Reports the wrench that was actually sent to the device for the last tick. A non-finite wrench is rejected. */
  palpate_status report_sent(const palpate_wrench &sent) noexcept { return palpate_local_world_report_sent(world_, &sent); }

  /* Returns the handle, for functions of palpate.h. */
  palpate_local_world *handle() noexcept { return world_; }

 private:
  palpate_local_world *world_ = nullptr;
};

/* Creates both sides of a local model, the loop's and the simulator's, each for its own thread. Throws Error for
   invalid parameters. */
inline std::pair<LocalWorld, LowRateSimulator> local_world(const palpate_local_params &params) {
  palpate_local_world *world = nullptr;
  palpate_low_rate_simulator *host = nullptr;
  detail::check_version();
  detail::check(palpate_local_world_new(&params, &world, &host));
  return {LocalWorld(world), LowRateSimulator(host)};
}

}  // namespace palpate
