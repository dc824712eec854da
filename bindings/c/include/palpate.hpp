/*
 * palpate for C++17: palpate.h with RAII handles. docs/integrate/c.md
 *
 * Creating and changing a contact or world throws palpate::Error on a wrong parameter. A tick is noexcept and returns
 * 0 N on any error.
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
#include "palpate_low_rate_simulator.hpp"
#include "palpate_span.hpp"

namespace palpate {

/* Returns the default loop parameters with a period [s]. */
inline palpate_loop_params loop_params(double period) {
  palpate_loop_params params = palpate_loop_params_default();
  params.period = period;
  return params;
}

/* Returns the parameters of a contact of `stiffness` [N/m] with an object of `mass` [kg], by default a wall. */
inline palpate_contact_params contact_params(double stiffness, double mass = INFINITY) {
  palpate_contact_params params = palpate_contact_params_default();
  params.stiffness = stiffness;
  params.object_mass = mass;
  return params;
}

/* Sets the settings of the method. `params` points to them, so the array must outlive the parameters; a temporary array
   does not compile. */
inline void use(palpate_contact_params &params, span<const palpate_setting> settings) noexcept {
  params.settings = settings.data();
  params.setting_count = settings.size();
}
template <typename Array, detail::if_temporary<Array> = 0>
void use(palpate_contact_params &params, Array &&settings) = delete;
template <std::size_t N>
void use(palpate_contact_params &params, const palpate_setting (&&settings)[N]) = delete;

/* Returns a world sample with one pose per device, in the order of the scene. It points to the poses, so the array must
   outlive the sample; a temporary array does not compile. */
inline palpate_world_sample world_sample(span<const palpate_pose> poses) noexcept {
  return palpate_world_sample_at(poses.data(), poses.size());
}
template <typename Array, detail::if_temporary<Array> = 0>
palpate_world_sample world_sample(Array &&poses) = delete;
template <std::size_t N>
palpate_world_sample world_sample(const palpate_pose (&&poses)[N]) = delete;

/* Shapes, in the axes of their tool or body. A hull or mesh points to its points and faces, so the arrays must outlive
   the shape; temporary arrays do not compile. */
inline palpate_shape sphere(double radius) noexcept {
  palpate_shape shape = palpate_shape_default();
  shape.radius = radius;
  return shape;
}

/* Returns a box with the given half lengths [m]. */
inline palpate_shape box(double x, double y, double z) noexcept {
  palpate_shape shape = palpate_shape_default();
  shape.kind = PALPATE_SHAPE_KIND_BOX;
  shape.half_extents[0] = x;
  shape.half_extents[1] = y;
  shape.half_extents[2] = z;
  return shape;
}

/* Returns the half-space behind the plane with normal x, y, z at distance `offset` [m]. */
inline palpate_shape half_space(double x, double y, double z, double offset = 0.0) noexcept {
  palpate_shape shape = palpate_shape_default();
  shape.kind = PALPATE_SHAPE_KIND_HALF_SPACE;
  shape.normal[0] = x;
  shape.normal[1] = y;
  shape.normal[2] = z;
  shape.offset = offset;
  return shape;
}

/* Returns the convex hull of points, three numbers per point [m]. */
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

/* Returns a mesh of triangles: three point indices each, counter-clockwise as seen from outside. */
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

/* Returns the contact law of `stiffness` [N/m]. */
inline palpate_contact_law contact_law(double stiffness, double damping = 0.0, double friction = 0.0) noexcept {
  palpate_contact_law law = palpate_contact_law_default();
  law.stiffness = stiffness;
  law.damping = damping;
  law.friction = friction;
  return law;
}

/* Returns the names of all methods. */
inline std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (std::size_t method = 0; method < palpate_method_count(); method++) {
    names.push_back(detail::text([&](char *memory, std::size_t size) {
      return palpate_method_text(method, PALPATE_ABOUT_METHOD_NAME, memory, size);
    }));
  }
  return names;
}

/* Returns the names of all methods for worlds. */
inline std::vector<std::string> world_method_names() {
  std::vector<std::string> names;
  for (std::size_t method = 0; method < palpate_world_method_count(); method++) {
    names.emplace_back(palpate_world_method_name(method));
  }
  return names;
}

/* Returns the name of a status, such as "struct-size". */
inline const char *name(palpate_status status) noexcept { return palpate_status_name(status); }

/* Returns the name of a fault, such as "gap-too-long". */
inline const char *name(palpate_fault fault) noexcept { return palpate_fault_name(fault); }

namespace detail {

/* Structs and functions of palpate.h for ticks in double or in float. */
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
  static constexpr auto report_sent_line = palpate_contact_report_sent_line;
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
  static constexpr auto report_sent_line = palpate_contact_f32_report_sent_line;
  static constexpr auto report_held = palpate_contact_f32_report_held;
  static constexpr auto change = palpate_contact_f32_change;
  static constexpr auto teleport = palpate_contact_f32_teleport;
  static Ledger empty_ledger() noexcept { return palpate_ledger_f32_empty(); }
  static constexpr auto ledger = palpate_contact_f32_ledger;
  static constexpr auto describe = palpate_contact_f32_describe;
};

}  // namespace detail

/* A rendered contact with ticks in `Number`: Contact and ContactF32, for an actuator that holds lines
   LineContact and LineContactF32. Only one thread may use it at a time. It is movable and not copyable; a moved-from
   contact returns 0 N. */
template <typename Number, palpate_hold Hold = PALPATE_HOLD_CONSTANT>
class BasicContact {
  using Ticks = detail::Ticks<Number>;

 public:
  using Handle = typename Ticks::Handle;
  using Sample = typename Ticks::Sample;
  using Output = typename Ticks::Output;
  using Ledger = typename Ticks::Ledger;

  /* Throws Error if a parameter is outside its range, or if loop.hold differs from the hold of the type. */
  BasicContact(const palpate_contact_params &params, const palpate_loop_params &loop) {
    detail::check_version();
    detail::check_hold(loop, Hold);
    detail::check(Ticks::make(&params, &loop, &contact_));
  }

  /* Creates the contact in caller-owned memory, which must outlive it: PALPATE_CONTACT_SIZE_MAX bytes aligned to
     PALPATE_CONTACT_ALIGN_MAX are enough. */
  BasicContact(span<unsigned char> memory, const palpate_contact_params &params, const palpate_loop_params &loop) {
    detail::check_version();
    detail::check_hold(loop, Hold);
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

  /* Executes one tick: returns the force on the device [N] for its position [m]. */
  Number step(Number device_position) noexcept { return step(Ticks::sample_at(device_position)); }

  /* Executes one tick with a full sample. */
  Number step(const Sample &sample) noexcept {
    static_assert(Hold == PALPATE_HOLD_CONSTANT, "the output has the slope of the line: call step(sample, output)");
    return Ticks::step(contact_, &sample, nullptr);
  }

  /* Executes one tick with a full sample and the full output, which an empty output receives. */
  Number step(const Sample &sample, Output &output) noexcept { return Ticks::step(contact_, &sample, &output); }

  /* Reports the force that was actually sent to the device for the last tick [N]. A non-finite force is rejected. */
  palpate_status report_sent(Number force_on_device) noexcept { return Ticks::report_sent(contact_, force_on_device); }

  /* Reports the line that was actually sent to the device for the last tick: its mean [N] and its slope [N/s]. */
  palpate_status report_sent_line(Number force_on_device, Number slope_on_device) noexcept {
    return Ticks::report_sent_line(contact_, force_on_device, slope_on_device);
  }

  /* Reports the measured mean force on the device since the last sample [N]. */
  palpate_status report_held(Number force_on_device) noexcept { return Ticks::report_held(contact_, force_on_device); }

  /* Changes the rendering from the next tick on, without a step in the force. Throws Error. */
  void change(const palpate_contact_params &params, const palpate_loop_params &loop) {
    detail::check_hold(loop, Hold);
    detail::check(Ticks::change(contact_, &params, &loop));
  }

  /* Moves the object to `position` [m] with `velocity` [m/s] at the next sample. Throws Error. */
  void teleport(Number position, Number velocity = 0) {
    detail::check(Ticks::teleport(contact_, position, velocity));
  }

  /* Returns the energy ledger up to the last sample. */
  Ledger ledger() const noexcept {
    Ledger ledger = Ticks::empty_ledger();
    Ticks::ledger(contact_, &ledger);
    return ledger;
  }

  /* Returns a description of the rendering. */
  std::string description() const {
    return detail::text(
        [this](char *memory, std::size_t size) { return Ticks::describe(contact_, memory, size); });
  }

  /* Returns the handle, for functions of palpate.h. */
  Handle *handle() noexcept { return contact_; }

 private:
  Handle *contact_ = nullptr;
};

using Contact = BasicContact<double>;
using ContactF32 = BasicContact<float>;
using LineContact = BasicContact<double, PALPATE_HOLD_LINE>;
using LineContactF32 = BasicContact<float, PALPATE_HOLD_LINE>;

/* Description of a world: devices, bodies, laws and joints, added by calls or read from a scene file. A
   rejected call throws Error and leaves the scene unchanged. Movable and not copyable. */
class Scene {
 public:
  /* Creates an empty scene. */
  explicit Scene(const palpate_scene_params &params) {
    detail::check_version();
    detail::check(palpate_scene_new(&params, &scene_));
  }

  /* Creates an empty scene with the default parameters and a period [s]. */
  explicit Scene(double period) : Scene(with_period(period)) {}

  /* Reads a scene file. */
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

  void set_guard(const palpate_guard_params &params) { detail::check(palpate_scene_set_guard(scene_, &params)); }

  void add_device(const std::string &name, const palpate_device_params &params, const palpate_shape &shape) {
    detail::check(palpate_scene_add_device(scene_, name.c_str(), &params, &shape));
  }

  void add_body(const std::string &name, const palpate_body_params &params, const palpate_shape &shape) {
    detail::check(palpate_scene_add_body(scene_, name.c_str(), &params, &shape));
  }

  /* Returns the parameters of a body. */
  palpate_body_params body(const std::string &name) const {
    palpate_body_params params = palpate_body_params_default();
    detail::check(palpate_scene_body(scene_, name.c_str(), &params));
    return params;
  }

  /* Replaces the parameters of a body, which keeps its shape. */
  void set_body(const std::string &name, const palpate_body_params &params) {
    detail::check(palpate_scene_set_body(scene_, name.c_str(), &params, nullptr));
  }

  /* Replaces the parameters and the shape of a body. */
  void set_body(const std::string &name, const palpate_body_params &params, const palpate_shape &shape) {
    detail::check(palpate_scene_set_body(scene_, name.c_str(), &params, &shape));
  }

  /* Removes a body with its joints and the laws that name it. */
  void remove_body(const std::string &name) { detail::check(palpate_scene_remove_body(scene_, name.c_str())); }

  /* Sets the contact law of a pair: two names, or "*" for any. */
  void set_law(const std::string &one, const std::string &other, const palpate_contact_law &law) {
    detail::check(palpate_scene_set_law(scene_, one.c_str(), other.c_str(), &law));
  }

  /* Returns the law of exactly this pair. */
  palpate_contact_law law(const std::string &one, const std::string &other) const {
    palpate_contact_law law = palpate_contact_law_default();
    detail::check(palpate_scene_law(scene_, one.c_str(), other.c_str(), &law));
    return law;
  }

  void remove_law(const std::string &one, const std::string &other) {
    detail::check(palpate_scene_remove_law(scene_, one.c_str(), other.c_str()));
  }

  /* Adds a joint between a body and the world. */
  void add_joint(const std::string &body, const palpate_joint_params &params) {
    detail::check(palpate_scene_add_joint(scene_, body.c_str(), nullptr, &params));
  }

  /* Adds a joint between two bodies. */
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

  /* Returns the handle, for functions of palpate.h. */
  palpate_scene *handle() const noexcept { return scene_; }

 private:
  static palpate_scene_params with_period(double period) noexcept {
    palpate_scene_params params = palpate_scene_params_default();
    params.period = period;
    return params;
  }

  palpate_scene *scene_ = nullptr;
};

/* A world of a scene or of a scene file. Only one thread may use it at a time. It is movable and not
   copyable; a moved-from world returns no force. */
class World {
 public:
  /* Throws Error if the scene cannot be read or rendered. */
  explicit World(const std::string &path, const palpate_world_params &params = palpate_world_params_default()) {
    detail::check_version();
    detail::check(palpate_world_open(path.c_str(), &params, &world_));
  }

  /* Creates the world of a scene, which is not modified. */
  explicit World(const Scene &scene, const palpate_world_params &params = palpate_world_params_default()) {
    detail::check_version();
    detail::check(palpate_world_of_scene(scene.handle(), &params, &world_));
  }

  /* Changes to another scene between two ticks: bodies with an existing name keep their motion. Throws Error and then
     leaves the world unchanged. It allocates, unlike a tick. */
  void change(const Scene &scene) { detail::check(palpate_world_change(world_, scene.handle())); }

  /* Moves a body between two ticks. Throws Error. */
  void place(std::size_t body, const palpate_body_state &state) {
    detail::check(palpate_world_place(world_, body, &state));
  }

  /* Returns the index of a body by its name, valid until the world is changed. Throws Error if there is no such body.
     */
  std::size_t body_named(const std::string &name) const {
    std::size_t body = 0;
    detail::check(palpate_world_body_named(world_, name.c_str(), &body));
    return body;
  }

  /* Returns the tool state of a device by its index in the scene. Throws Error if there is no such device. */
  palpate_device_state device(std::size_t device) const {
    palpate_device_state state = palpate_device_state_empty();
    detail::check(palpate_world_device_state(world_, device, &state));
    return state;
  }

  /* Returns the state of a contact point. Throws Error if there is no such point. */
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

  /* Executes one tick: reads one pose per device and writes one wrench per device. Returns the reason if the wrenches
     are 0; a wrong number of poses or wrenches is PALPATE_FAULT_ARGUMENT. */
  palpate_fault step(span<const palpate_pose> poses, span<palpate_wrench> wrenches) noexcept {
    return step(world_sample(poses), wrenches, nullptr);
  }

  /* Executes one tick of a world of one device. */
  palpate_fault step(const palpate_pose &pose, palpate_wrench &wrench) noexcept {
    return step(span<const palpate_pose>(&pose, 1), span<palpate_wrench>(&wrench, 1));
  }

  /* Executes one tick with a full sample and, if `output` is not null, the full output. */
  palpate_fault step(const palpate_world_sample &sample, span<palpate_wrench> wrenches,
                     palpate_world_output *output) noexcept {
    return palpate_world_step(world_, &sample, wrenches.data(), wrenches.size(), output);
  }

  /* Reports the wrench that was actually sent to a device for the last tick. A non-finite wrench is rejected. */
  palpate_status report_sent(std::size_t device, const palpate_wrench &sent) noexcept {
    return palpate_world_report_sent(world_, device, &sent);
  }

  std::size_t device_count() const noexcept { return palpate_world_device_count(world_); }
  std::size_t body_count() const noexcept { return palpate_world_body_count(world_); }
  /* Returns the nominal sampling period [s]. */
  double period() const noexcept { return palpate_world_period(world_); }
  std::string device_name(std::size_t device) const { return name(palpate_world_device_name(world_, device)); }
  std::string body_name(std::size_t body) const { return name(palpate_world_body_name(world_, body)); }

  /* Returns pose and velocities of a body by its index in the scene. Throws Error if there is no such body. */
  palpate_body_state body(std::size_t body) const {
    palpate_body_state state = palpate_body_state_empty();
    detail::check(palpate_world_body_state(world_, body, &state));
    return state;
  }

  /* Writes the states of the first `states.size()` bodies of the scene. Throws Error if there are fewer. */
  void bodies(span<palpate_body_state> states) const {
    for (std::size_t body = 0; body < states.size(); body++) {
      states[body] = this->body(body);
    }
  }

  /* Returns the sums of the energy ledger up to the last sample. */
  palpate_world_ledger ledger() const noexcept {
    palpate_world_ledger ledger = palpate_world_ledger_empty();
    palpate_world_ledger_of(world_, &ledger);
    return ledger;
  }

  /* Returns the handle, for functions of palpate.h. */
  palpate_world *handle() noexcept { return world_; }

 private:
  static std::string name(const char *name) { return name == nullptr ? std::string() : std::string(name); }

  palpate_world *world_ = nullptr;
};

/* A recording in progress. Only one thread may use it at a time. It is movable and not copyable; a moved-from or closed
   recorder records nothing. The destructor closes the recording and ignores errors. */
class Recorder {
 public:
  /* Throws Error if the file cannot be created; an existing file is not replaced. */
  template <palpate_hold Hold>
  Recorder(BasicContact<double, Hold> &contact, const std::string &path,
           const palpate_recorder_params &params = palpate_recorder_params_default()) {
    detail::check(palpate_recorder_of_contact(contact.handle(), path.c_str(), &params, &recorder_));
  }

  /* Records one device of a world of several, by its index in the scene: use one recorder for each. */
  Recorder(World &world, std::size_t device, const std::string &path,
           const palpate_recorder_params &params = palpate_recorder_params_default()) {
    detail::check(palpate_recorder_of_device(world.handle(), device, path.c_str(), &params, &recorder_));
  }

  /* Records a world of one device. */
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

  /* Records a tick after its step, with the force [N] and the slope [N/s] that were actually sent. It never waits. */
  palpate_status tick(Contact &contact, const palpate_sample &sample, const palpate_output &output,
                      double sent_force) noexcept {
    return palpate_recorder_contact_tick(recorder_, contact.handle(), &sample, &output, sent_force, 0.0);
  }

  palpate_status tick(LineContact &contact, const palpate_sample &sample, const palpate_output &output,
                      double sent_force, double sent_slope) noexcept {
    return palpate_recorder_contact_tick(recorder_, contact.handle(), &sample, &output, sent_force, sent_slope);
  }

  /* Records a tick of a world, with the wrench that was actually sent to the recorded device. */
  palpate_status tick(World &world, const palpate_world_sample &sample, const palpate_world_output &output,
                      const palpate_wrench &sent) noexcept {
    return palpate_recorder_world_tick(recorder_, world.handle(), &sample, &output, &sent);
  }

  /* Returns the number of dropped ticks so far. */
  std::uint64_t lost() const noexcept { return palpate_recorder_lost(recorder_); }

  /* Waits until everything is written and returns the result of the recording. Throws Error if writing failed. */
  palpate_recorded close() {
    palpate_recorded recorded = palpate_recorded_empty();
    detail::check(palpate_recorder_close(std::exchange(recorder_, nullptr), &recorded));
    return recorded;
  }

  /* Returns the handle, for functions of palpate.h. */
  palpate_recorder *handle() noexcept { return recorder_; }

 private:
  palpate_recorder *recorder_ = nullptr;
};

}  // namespace palpate
