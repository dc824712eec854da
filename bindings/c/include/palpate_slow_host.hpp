/*
 * Local models of slow hosts for C++17; a part of palpate.hpp. docs/integrate/c.md
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

/* A slow host, such as a physics engine of 60 Hz: the host's end of a local model, for the host's thread. It can be moved and not
   copied; one that was moved from publishes nothing. */
class SlowHost {
 public:
  explicit SlowHost(palpate_slow_host *host) noexcept : host_(host) {}
  SlowHost(SlowHost &&other) noexcept : host_(std::exchange(other.host_, nullptr)) {}

  SlowHost &operator=(SlowHost &&other) noexcept {
    std::swap(host_, other.host_);
    return *this;
  }

  SlowHost(const SlowHost &) = delete;
  SlowHost &operator=(const SlowHost &) = delete;

  ~SlowHost() { palpate_slow_host_free(host_); }

  /* How far the loop has come, and what the tool has given to each body. Throws Error for another number of bodies. */
  palpate_progress progress(span<palpate_body_progress> bodies) {
    palpate_progress progress = palpate_progress_empty();
    detail::check(palpate_slow_host_progress(host_, &progress, bodies.data(), bodies.size()));
    return progress;
  }

  /* Publishes bodies and contacts as of the tick of a progress. Throws Error, which says all that is wrong; the model before stays
     then. */
  void publish(std::uint64_t tick, span<const palpate_host_body> bodies, span<const palpate_host_contact> contacts) {
    detail::check(
        palpate_slow_host_publish(host_, tick, bodies.data(), bodies.size(), contacts.data(), contacts.size()));
  }

  /* The handle, for functions of palpate.h. */
  palpate_slow_host *handle() noexcept { return host_; }

 private:
  palpate_slow_host *host_ = nullptr;
};

/* What a slow host publishes, as the fast loop renders it: the loop's end, for the thread that samples the device. It can be moved
   and not copied; one that was moved from gives no force. */
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

  /* One tick: the pose of the device in, what it is to hold out. Why there is no force, where there is none. */
  palpate_fault step(const palpate_pose &pose, palpate_wrench &wrench, palpate_local_output *output = nullptr) noexcept {
    return step(palpate_world_sample_at(&pose, 1), wrench, output);
  }

  /* The same with all that goes in. */
  palpate_fault step(const palpate_world_sample &sample, palpate_wrench &wrench, palpate_local_output *output) noexcept {
    return palpate_local_world_step(world_, &sample, &wrench, output);
  }

  /* What was really sent to the device for the last tick. What is not finite is refused. */
  palpate_status report_sent(const palpate_wrench &sent) noexcept { return palpate_local_world_report_sent(world_, &sent); }

  /* The handle, for functions of palpate.h. */
  palpate_local_world *handle() noexcept { return world_; }

 private:
  palpate_local_world *world_ = nullptr;
};

/* Both ends of a local model: the loop's and the host's, each for a thread of its own. Throws Error for parameters that cannot
   be. */
inline std::pair<LocalWorld, SlowHost> local_world(const palpate_local_params &params) {
  palpate_local_world *world = nullptr;
  palpate_slow_host *host = nullptr;
  detail::check_version();
  detail::check(palpate_local_world_new(&params, &world, &host));
  return {LocalWorld(world), SlowHost(host)};
}

}  // namespace palpate
