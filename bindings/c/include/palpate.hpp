/*
 * palpate for C++17: palpate.h with handles that free themselves. docs/integrate/c.md
 *
 * What is checked once throws palpate::Error: making a contact or a world, and changing it. A tick is noexcept and
 * gives 0 N where anything is wrong.
 *
 * License: MIT OR Apache-2.0
 */
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "palpate.h"
#include "palpate_error.hpp"
#include "palpate_slow_host.hpp"
#include "palpate_span.hpp"

namespace palpate {

/* The parameters of the loop, with every default and a period [s]. */
inline palpate_loop_params loop_params(double period) {
  palpate_loop_params params = palpate_loop_params_default();
  params.period = period;
  return params;
}

/* A contact of `stiffness` [N/m] with an object of `mass` [kg]; without a mass, with a wall. */
inline palpate_contact_params contact_params(double stiffness, double mass = INFINITY) {
  palpate_contact_params params = palpate_contact_params_default();
  params.stiffness = stiffness;
  params.object_mass = mass;
  return params;
}

/* Sets the settings of the method. `params` points to them, so the array has to outlive the parameters; a temporary array does
   not compile. */
inline void use(palpate_contact_params &params, span<const palpate_setting> settings) noexcept {
  params.settings = settings.data();
  params.setting_count = settings.size();
}
template <typename Array, detail::if_temporary<Array> = 0>
void use(palpate_contact_params &params, Array &&settings) = delete;
template <std::size_t N>
void use(palpate_contact_params &params, const palpate_setting (&&settings)[N]) = delete;

/* A sample of a world: a pose of each device, in the order of the scene. It points to the poses, so the array has to outlive
   the sample; a temporary array does not compile. */
inline palpate_world_sample world_sample(span<const palpate_pose> poses) noexcept {
  return palpate_world_sample_at(poses.data(), poses.size());
}
template <typename Array, detail::if_temporary<Array> = 0>
palpate_world_sample world_sample(Array &&poses) = delete;
template <std::size_t N>
palpate_world_sample world_sample(const palpate_pose (&&poses)[N]) = delete;

/* Shapes, in the own axes of the tool or body that has them. A hull or mesh points to its points and faces, so the arrays have
   to outlive the shape; temporary arrays do not compile. */
inline palpate_shape sphere(double radius) noexcept {
  palpate_shape shape = palpate_shape_default();
  shape.radius = radius;
  return shape;
}

/* A block, by half of its lengths [m]. */
inline palpate_shape box(double x, double y, double z) noexcept {
  palpate_shape shape = palpate_shape_default();
  shape.kind = PALPATE_SHAPE_KIND_BOX;
  shape.half_extents[0] = x;
  shape.half_extents[1] = y;
  shape.half_extents[2] = z;
  return shape;
}

/* All that is behind a plane across a direction, `offset` along it [m]. */
inline palpate_shape half_space(double x, double y, double z, double offset = 0.0) noexcept {
  palpate_shape shape = palpate_shape_default();
  shape.kind = PALPATE_SHAPE_KIND_HALF_SPACE;
  shape.normal[0] = x;
  shape.normal[1] = y;
  shape.normal[2] = z;
  shape.offset = offset;
  return shape;
}

/* The convex hull of points, three numbers for each [m]. */
inline palpate_shape hull(span<const double> points) noexcept {
  palpate_shape shape = palpate_shape_default();
  shape.kind = PALPATE_SHAPE_KIND_HULL;
  shape.points = points.data();
  shape.point_count = points.size() / 3;
  return shape;
}
template <typename Points, detail::if_temporary<Points> = 0>
palpate_shape hull(Points &&points) = delete;
template <std::size_t N>
palpate_shape hull(const double (&&points)[N]) = delete;

/* Triangles, by the places of three points for each, in turn to the left as they are seen from outside. */
inline palpate_shape mesh(span<const double> points, span<const std::uint32_t> faces) noexcept {
  palpate_shape shape = hull(points);
  shape.kind = PALPATE_SHAPE_KIND_MESH;
  shape.faces = faces.data();
  shape.face_count = faces.size() / 3;
  return shape;
}
template <typename Points, typename Faces, detail::if_temporary<Points, Faces> = 0>
palpate_shape mesh(Points &&points, Faces &&faces) = delete;
template <std::size_t N>
palpate_shape mesh(const double (&&points)[N], span<const std::uint32_t> faces) = delete;
template <std::size_t N>
palpate_shape mesh(span<const double> points, const std::uint32_t (&&faces)[N]) = delete;

/* The law of a contact of `stiffness` [N/m]. */
inline palpate_contact_law contact_law(double stiffness, double damping = 0.0, double friction = 0.0) noexcept {
  palpate_contact_law law = palpate_contact_law_default();
  law.stiffness = stiffness;
  law.damping = damping;
  law.friction = friction;
  return law;
}

/* The names of all methods. */
inline std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (std::size_t method = 0; method < palpate_method_count(); method++) {
    names.push_back(detail::text([&](char *memory, std::size_t size) {
      return palpate_method_text(method, PALPATE_ABOUT_METHOD_NAME, memory, size);
    }));
  }
  return names;
}

/* The names of all methods for worlds. */
inline std::vector<std::string> world_method_names() {
  std::vector<std::string> names;
  for (std::size_t method = 0; method < palpate_world_method_count(); method++) {
    names.emplace_back(palpate_world_method_name(method));
  }
  return names;
}

/* The name of a status, such as "struct-size". */
inline const char *name(palpate_status status) noexcept { return palpate_status_name(status); }

/* The name of a fault, such as "gap-too-long". */
inline const char *name(palpate_fault fault) noexcept { return palpate_fault_name(fault); }

namespace detail {

/* The structs and functions of palpate.h for ticks in double or in float. */
template <typename Number>
struct Ticks;

template <>
struct Ticks<double> {
  using Handle = palpate_contact;
  using Sample = palpate_sample;
  using Output = palpate_output;
  using Ledger = palpate_ledger;
  static constexpr auto make = palpate_contact_new;
  static constexpr auto place = palpate_contact_place;
  static constexpr auto free = palpate_contact_free;
  static Sample sample_at(double device_position) noexcept { return palpate_sample_at(device_position); }
  static constexpr auto step = palpate_contact_step;
  static constexpr auto report_sent = palpate_contact_report_sent;
  static constexpr auto report_held = palpate_contact_report_held;
  static constexpr auto change = palpate_contact_change;
  static constexpr auto teleport = palpate_contact_teleport;
  static Ledger empty_ledger() noexcept { return palpate_ledger_empty(); }
  static constexpr auto ledger = palpate_contact_ledger;
  static constexpr auto describe = palpate_contact_describe;
};

template <>
struct Ticks<float> {
  using Handle = palpate_contact_f32;
  using Sample = palpate_sample_f32;
  using Output = palpate_output_f32;
  using Ledger = palpate_ledger_f32;
  static constexpr auto make = palpate_contact_f32_new;
  static constexpr auto place = palpate_contact_f32_place;
  static constexpr auto free = palpate_contact_f32_free;
  static Sample sample_at(float device_position) noexcept { return palpate_sample_f32_at(device_position); }
  static constexpr auto step = palpate_contact_f32_step;
  static constexpr auto report_sent = palpate_contact_f32_report_sent;
  static constexpr auto report_held = palpate_contact_f32_report_held;
  static constexpr auto change = palpate_contact_f32_change;
  static constexpr auto teleport = palpate_contact_f32_teleport;
  static Ledger empty_ledger() noexcept { return palpate_ledger_f32_empty(); }
  static constexpr auto ledger = palpate_contact_f32_ledger;
  static constexpr auto describe = palpate_contact_f32_describe;
};

}  // namespace detail

/* A contact that is rendered, with ticks in `Number`: Contact and ContactF32. One thread at a time may use it. It can be
   moved and not copied; one that was moved from gives 0 N. */
template <typename Number>
class BasicContact {
  using Ticks = detail::Ticks<Number>;

 public:
  using Handle = typename Ticks::Handle;
  using Sample = typename Ticks::Sample;
  using Output = typename Ticks::Output;
  using Ledger = typename Ticks::Ledger;

  /* Throws Error where a parameter is outside its range. */
  BasicContact(const palpate_contact_params &params, const palpate_loop_params &loop) {
    detail::check_version();
    detail::check(Ticks::make(&params, &loop, &contact_));
  }

  /* The same in memory of the caller's, which stays as long as the contact: PALPATE_CONTACT_SIZE_MAX bytes at a multiple of
     PALPATE_CONTACT_ALIGN_MAX are enough. */
  BasicContact(span<unsigned char> memory, const palpate_contact_params &params, const palpate_loop_params &loop) {
    detail::check_version();
    detail::check(Ticks::place(memory.data(), memory.size(), &params, &loop, &contact_));
  }

  BasicContact(BasicContact &&other) noexcept : contact_(std::exchange(other.contact_, nullptr)) {}

  BasicContact &operator=(BasicContact &&other) noexcept {
    std::swap(contact_, other.contact_);
    return *this;
  }

  BasicContact(const BasicContact &) = delete;
  BasicContact &operator=(const BasicContact &) = delete;

  ~BasicContact() { Ticks::free(contact_); }

  /* One tick: the force on the device [N], from its position [m]. */
  Number step(Number device_position) noexcept { return step(Ticks::sample_at(device_position), nullptr); }

  /* One tick, with all that goes in and, where `output` is not null, all that comes out. */
  Number step(const Sample &sample, Output *output) noexcept { return Ticks::step(contact_, &sample, output); }

  /* The force on the device that was really sent for the last tick [N]. What is not finite is refused. */
  palpate_status report_sent(Number force_on_device) noexcept { return Ticks::report_sent(contact_, force_on_device); }

  /* The force on the device that has really acted since the last sample, in the mean [N]. */
  palpate_status report_held(Number force_on_device) noexcept { return Ticks::report_held(contact_, force_on_device); }

  /* Renders something else from the next tick on, without a step in the force. Throws Error. */
  void change(const palpate_contact_params &params, const palpate_loop_params &loop) {
    detail::check(Ticks::change(contact_, &params, &loop));
  }

  /* Puts the object at `position` [m] with `velocity` [m/s] with the next sample. Throws Error. */
  void teleport(Number position, Number velocity = 0) {
    detail::check(Ticks::teleport(contact_, position, velocity));
  }

  /* The books up to the last sample. */
  Ledger ledger() const noexcept {
    Ledger ledger = Ticks::empty_ledger();
    Ticks::ledger(contact_, &ledger);
    return ledger;
  }

  /* What is rendered, in words. */
  std::string description() const {
    return detail::text(
        [this](char *memory, std::size_t size) { return Ticks::describe(contact_, memory, size); });
  }

  /* The handle, for functions of palpate.h. */
  Handle *handle() noexcept { return contact_; }

 private:
  Handle *contact_ = nullptr;
};

/* A contact with ticks in double. */
using Contact = BasicContact<double>;
/* The same in float. */
using ContactF32 = BasicContact<float>;

/* What a world is made of: devices, bodies, laws and joints, by calls or from a scene file of format 2. Every call throws Error
   where it is refused, and leaves the scene as it was. It can be moved and not copied. */
class Scene {
 public:
  /* An empty scene. */
  explicit Scene(const palpate_scene_params &params) {
    detail::check_version();
    detail::check(palpate_scene_new(&params, &scene_));
  }

  /* The same with every default and a period [s]. */
  explicit Scene(double period) : Scene(with_period(period)) {}

  /* That of a file. */
  explicit Scene(const std::string &path) {
    detail::check_version();
    detail::check(palpate_scene_open(path.c_str(), &scene_));
  }

  Scene(Scene &&other) noexcept : scene_(std::exchange(other.scene_, nullptr)) {}

  Scene &operator=(Scene &&other) noexcept {
    std::swap(scene_, other.scene_);
    return *this;
  }

  Scene(const Scene &) = delete;
  Scene &operator=(const Scene &) = delete;

  ~Scene() { palpate_scene_free(scene_); }

  void add_device(const std::string &name, const palpate_device_params &params, const palpate_shape &shape) {
    detail::check(palpate_scene_add_device(scene_, name.c_str(), &params, &shape));
  }

  void add_body(const std::string &name, const palpate_body_params &params, const palpate_shape &shape) {
    detail::check(palpate_scene_add_body(scene_, name.c_str(), &params, &shape));
  }

  /* What the scene says of a body. */
  palpate_body_params body(const std::string &name) const {
    palpate_body_params params = palpate_body_params_default();
    detail::check(palpate_scene_body(scene_, name.c_str(), &params));
    return params;
  }

  /* Says another thing of a body, which keeps its shape. */
  void set_body(const std::string &name, const palpate_body_params &params) {
    detail::check(palpate_scene_set_body(scene_, name.c_str(), &params, nullptr));
  }

  /* The same with another shape. */
  void set_body(const std::string &name, const palpate_body_params &params, const palpate_shape &shape) {
    detail::check(palpate_scene_set_body(scene_, name.c_str(), &params, &shape));
  }

  /* Takes a body out, with its joints and the laws that name it. */
  void remove_body(const std::string &name) { detail::check(palpate_scene_remove_body(scene_, name.c_str())); }

  /* Lets two touch by a law: names, or "*" for all. */
  void set_law(const std::string &one, const std::string &other, const palpate_contact_law &law) {
    detail::check(palpate_scene_set_law(scene_, one.c_str(), other.c_str(), &law));
  }

  /* The law between just these. */
  palpate_contact_law law(const std::string &one, const std::string &other) const {
    palpate_contact_law law = palpate_contact_law_default();
    detail::check(palpate_scene_law(scene_, one.c_str(), other.c_str(), &law));
    return law;
  }

  void remove_law(const std::string &one, const std::string &other) {
    detail::check(palpate_scene_remove_law(scene_, one.c_str(), other.c_str()));
  }

  /* A joint of a body with the world. */
  void add_joint(const std::string &body, const palpate_joint_params &params) {
    detail::check(palpate_scene_add_joint(scene_, body.c_str(), nullptr, &params));
  }

  /* A joint of a body with another one. */
  void add_joint(const std::string &body, const std::string &against, const palpate_joint_params &params) {
    detail::check(palpate_scene_add_joint(scene_, body.c_str(), against.c_str(), &params));
  }

  void set_joint(std::size_t joint, const palpate_joint_params &params) {
    detail::check(palpate_scene_set_joint(scene_, joint, &params));
  }

  void remove_joint(std::size_t joint) { detail::check(palpate_scene_remove_joint(scene_, joint)); }

  std::size_t device_count() const noexcept { return palpate_scene_device_count(scene_); }
  std::size_t body_count() const noexcept { return palpate_scene_body_count(scene_); }
  std::size_t joint_count() const noexcept { return palpate_scene_joint_count(scene_); }

  /* The handle, for functions of palpate.h. */
  palpate_scene *handle() const noexcept { return scene_; }

 private:
  static palpate_scene_params with_period(double period) noexcept {
    palpate_scene_params params = palpate_scene_params_default();
    params.period = period;
    return params;
  }

  palpate_scene *scene_ = nullptr;
};

/* A world, of a scene or of a scene file of format 2. One thread at a time may use it. It can be moved and not copied; one that was moved
   from gives no force. */
class World {
 public:
  /* Throws Error where the scene cannot be read or rendered; every default without `params`. */
  explicit World(const std::string &path, const palpate_world_params &params = palpate_world_params_default()) {
    detail::check_version();
    detail::check(palpate_world_open(path.c_str(), &params, &world_));
  }

  /* The world of a scene, which stays as it is. */
  explicit World(const Scene &scene, const palpate_world_params &params = palpate_world_params_default()) {
    detail::check_version();
    detail::check(palpate_world_of_scene(scene.handle(), &params, &world_));
  }

  /* Goes on with another scene between two ticks: what is there by its name already moves on. Throws Error; the world is then
     as it was. It takes memory, which a tick does not. */
  void change(const Scene &scene) { detail::check(palpate_world_change(world_, scene.handle())); }

  /* Puts a body elsewhere between two ticks. Throws Error. */
  void place(std::size_t body, const palpate_body_state &state) {
    detail::check(palpate_world_place(world_, body, &state));
  }

  /* The place of a body by its name, until the world is changed. Throws Error where there is none. */
  std::size_t body_named(const std::string &name) const {
    std::size_t body = 0;
    detail::check(palpate_world_body_named(world_, name.c_str(), &body));
    return body;
  }

  /* Where the tool of a device is, by its place in the scene. Throws Error where there is none. */
  palpate_device_state device(std::size_t device) const {
    palpate_device_state state = palpate_device_state_empty();
    detail::check(palpate_world_device_state(world_, device, &state));
    return state;
  }

  /* What a point of contact does. Throws Error where there is none. */
  palpate_contact_state contact(std::size_t contact) const {
    palpate_contact_state state = palpate_contact_state_empty();
    detail::check(palpate_world_contact_state(world_, contact, &state));
    return state;
  }

  std::size_t contact_count() const noexcept { return palpate_world_contact_count(world_); }

  World(World &&other) noexcept : world_(std::exchange(other.world_, nullptr)) {}

  World &operator=(World &&other) noexcept {
    std::swap(world_, other.world_);
    return *this;
  }

  World(const World &) = delete;
  World &operator=(const World &) = delete;

  ~World() { palpate_world_free(world_); }

  /* One tick: a pose of each device in, what it is to hold out. Why there is no force, where there is none; another number of
     poses or wrenches than of devices is PALPATE_FAULT_ARGUMENT. */
  palpate_fault step(span<const palpate_pose> poses, span<palpate_wrench> wrenches) noexcept {
    return step(world_sample(poses), wrenches, nullptr);
  }

  /* The same of a world of one device. */
  palpate_fault step(const palpate_pose &pose, palpate_wrench &wrench) noexcept {
    return step(span<const palpate_pose>(&pose, 1), span<palpate_wrench>(&wrench, 1));
  }

  /* One tick, with all that goes in and, where `output` is not null, all that comes out. */
  palpate_fault step(const palpate_world_sample &sample, span<palpate_wrench> wrenches,
                     palpate_world_output *output) noexcept {
    return palpate_world_step(world_, &sample, wrenches.data(), wrenches.size(), output);
  }

  /* What was really sent to a device for the last tick. What is not finite is refused. */
  palpate_status report_sent(std::size_t device, const palpate_wrench &sent) noexcept {
    return palpate_world_report_sent(world_, device, &sent);
  }

  std::size_t device_count() const noexcept { return palpate_world_device_count(world_); }
  std::size_t body_count() const noexcept { return palpate_world_body_count(world_); }
  /* The nominal time from sample to sample [s]. */
  double period() const noexcept { return palpate_world_period(world_); }
  std::string device_name(std::size_t device) const { return name(palpate_world_device_name(world_, device)); }
  std::string body_name(std::size_t body) const { return name(palpate_world_body_name(world_, body)); }

  /* Where a body is and how it moves, by its place in the scene. Throws Error where there is none. */
  palpate_body_state body(std::size_t body) const {
    palpate_body_state state = palpate_body_state_empty();
    detail::check(palpate_world_body_state(world_, body, &state));
    return state;
  }

  /* The same of the first bodies of the scene, as many as `states` has room for. Throws Error where there are fewer. */
  void bodies(span<palpate_body_state> states) const {
    for (std::size_t body = 0; body < states.size(); body++) {
      states[body] = this->body(body);
    }
  }

  /* The sums of the books up to the last sample. */
  palpate_world_ledger ledger() const noexcept {
    palpate_world_ledger ledger = palpate_world_ledger_empty();
    palpate_world_ledger_of(world_, &ledger);
    return ledger;
  }

  /* The handle, for functions of palpate.h. */
  palpate_world *handle() noexcept { return world_; }

 private:
  static std::string name(const char *name) { return name == nullptr ? std::string() : std::string(name); }

  palpate_world *world_ = nullptr;
};

/* A recording that is being written. One thread at a time may use it. It can be moved and not copied; one that was moved from
   or closed records nothing. What is not closed is closed in the end, and nobody hears whether that worked. */
class Recorder {
 public:
  /* Throws Error where the file cannot be begun; a file that is there is not replaced. Every default without `params`. */
  Recorder(Contact &contact, const std::string &path,
           const palpate_recorder_params &params = palpate_recorder_params_default()) {
    detail::check(palpate_recorder_of_contact(contact.handle(), path.c_str(), &params, &recorder_));
  }

  /* The same of one device of a world of several, by its place in the scene: each has a recording of its own. */
  Recorder(World &world, std::size_t device, const std::string &path,
           const palpate_recorder_params &params = palpate_recorder_params_default()) {
    detail::check(palpate_recorder_of_device(world.handle(), device, path.c_str(), &params, &recorder_));
  }

  /* The same of a world of one device. */
  Recorder(World &world, const std::string &path,
           const palpate_recorder_params &params = palpate_recorder_params_default()) {
    detail::check(palpate_recorder_of_world(world.handle(), path.c_str(), &params, &recorder_));
  }

  Recorder(Recorder &&other) noexcept : recorder_(std::exchange(other.recorder_, nullptr)) {}

  Recorder &operator=(Recorder &&other) noexcept {
    std::swap(recorder_, other.recorder_);
    return *this;
  }

  Recorder(const Recorder &) = delete;
  Recorder &operator=(const Recorder &) = delete;

  ~Recorder() { palpate_recorder_close(recorder_, nullptr); }

  /* A tick after its step, with the force on the device that was really sent [N]. It waits for nothing. */
  palpate_status tick(Contact &contact, const palpate_sample &sample, const palpate_output &output,
                      double sent_force) noexcept {
    return palpate_recorder_contact_tick(recorder_, contact.handle(), &sample, &output, sent_force);
  }

  /* The same of a world, with what was really sent to the device that is recorded. */
  palpate_status tick(World &world, const palpate_world_sample &sample, const palpate_world_output &output,
                      const palpate_wrench &sent) noexcept {
    return palpate_recorder_world_tick(recorder_, world.handle(), &sample, &output, &sent);
  }

  /* Ticks that found no room so far. */
  std::uint64_t lost() const noexcept { return palpate_recorder_lost(recorder_); }

  /* Waits until everything is written; what the recording has. Throws Error where the system refused to write. */
  palpate_recorded close() {
    palpate_recorded recorded = palpate_recorded_empty();
    detail::check(palpate_recorder_close(std::exchange(recorder_, nullptr), &recorded));
    return recorded;
  }

  /* The handle, for functions of palpate.h. */
  palpate_recorder *handle() noexcept { return recorder_; }

 private:
  palpate_recorder *recorder_ = nullptr;
};

}  // namespace palpate
