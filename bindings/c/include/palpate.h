/*
 * palpate: the force between a haptic device and a virtual object, at the loop rate of the device.
 * SI units: positions in m, times in s, masses in kg, forces in N, energies in J. docs/integrate/c.md
 *
 * Made from bindings/c/src by cbindgen; do not edit. License: MIT OR Apache-2.0
 */

#pragma once

#include <stddef.h>
#include <stdint.h>

/*
 Version of this interface. It goes up with a change that a compiled program would not survive; what
 is only added leaves it as it is.
 */
#define PALPATE_ABI_VERSION 1

/*
 Bytes that a contact has at most, for memory that is laid out by the compiler;
 palpate_contact_size() says how many it has.
 */
#define PALPATE_CONTACT_SIZE_MAX 4096

/*
 A multiple of this is where a contact may begin; palpate_contact_align() says what it needs.
 */
#define PALPATE_CONTACT_ALIGN_MAX 8

/*
 Bytes that a contact in float has at most, for memory that is laid out by the compiler;
 palpate_contact_f32_size() says how many it has. It may begin at a multiple of PALPATE_CONTACT_ALIGN_MAX.
 */
#define PALPATE_CONTACT_F32_SIZE_MAX 2048

/*
 `first_body` and `second_body` where that is a device.
 */
#define PALPATE_NO_BODY UINT32_MAX

/*
 `fault_device` where the fault is none of one device.
 */
#define PALPATE_NO_DEVICE UINT32_MAX

/*
 What a call answers. `palpate_last_error` says the rest in words, palpate_status_name has the names of these.

 A status says where the error is, whatever was called: NULL, STRUCT_SIZE and MEMORY at a pointer and what it points to,
 PARAMETER at a number, SETTING at a text, COUNT at a place or a number of things, SCENE at what a scene has, CHANGE at what
 runs already, RECORDING at a file of ticks. Of several errors it is that of the first one.

 A call that is refused changes nothing. There are three exceptions: a call that makes something puts NULL in place of it,
 palpate_recorder_close frees the recorder whatever it answers, and after INTERNAL everything that was used can only be freed.
 */
enum palpate_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Done.
   */
  PALPATE_STATUS_OK = 0,
  /*
   A pointer is NULL that may not be.
   */
  PALPATE_STATUS_NULL = 1,
  /*
   A struct_size is too small, or larger than the library knows and the rest is not 0.
   */
  PALPATE_STATUS_STRUCT_SIZE = 2,
  /*
   A number of the call, or of a struct or an array of it, is outside its range: one that stands for a choice or a switch, too,
   and a reserved one that is not 0.
   */
  PALPATE_STATUS_PARAMETER = 3,
  /*
   A text is not UTF-8, or none of the methods, settings and words that there are; a setting is given twice, or is missing.
   */
  PALPATE_STATUS_SETTING = 4,
  /*
   What runs cannot change to that: another period, another side of the device, other devices, a fixed body that is to move.
   */
  PALPATE_STATUS_CHANGE = 5,
  /*
   The memory that was given is too small or not aligned, an array cannot have so many elements, or the system has no memory
   for what was asked.
   */
  PALPATE_STATUS_MEMORY = 6,
  /*
   A defect in the library, which has been caught. Report it, please.
   */
  PALPATE_STATUS_INTERNAL = 7,
  /*
   A scene cannot be read, is none of a world, or cannot be rendered; it has no such name, or has that name already.
   */
  PALPATE_STATUS_SCENE = 8,
  /*
   A place, or a number of devices or bodies, is another one than there are.
   */
  PALPATE_STATUS_COUNT = 9,
  /*
   A recording cannot be begun or written, or a tick is of something else than what is recorded.
   */
  PALPATE_STATUS_RECORDING = 10,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_status palpate_status;
#else
typedef uint32_t palpate_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 What the object is predicted to do in the coming interval.
 */
enum palpate_phase
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   No contact.
   */
  PALPATE_PHASE_FREE = 0,
  /*
   In contact throughout.
   */
  PALPATE_PHASE_CONTACT = 1,
  /*
   Contact begins within the interval.
   */
  PALPATE_PHASE_ENTERS = 2,
  /*
   Contact ends within the interval.
   */
  PALPATE_PHASE_LEAVES = 3,
  /*
   A fault: the object waits.
   */
  PALPATE_PHASE_WAITING = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_phase palpate_phase;
#else
typedef uint32_t palpate_phase;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Why a sample was refused: the force is then 0, and the next sample that can be trusted takes up
 rendering.
 */
enum palpate_fault
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   It was not refused.
   */
  PALPATE_FAULT_NONE = 0,
  /*
   The device position is not a finite number.
   */
  PALPATE_FAULT_POSITION_NOT_FINITE = 1,
  /*
   The virtual force is not a finite number.
   */
  PALPATE_FAULT_VIRTUAL_FORCE_NOT_FINITE = 2,
  /*
   The time since the sample before is not positive.
   */
  PALPATE_FAULT_ELAPSED_NOT_POSITIVE = 3,
  /*
   The time since the sample before exceeds the largest gap.
   */
  PALPATE_FAULT_GAP_TOO_LONG = 4,
  /*
   The device position jumped faster than the speed limit.
   */
  PALPATE_FAULT_JUMP_TOO_FAST = 5,
  /*
   The force or the object's motion would not be a finite number.
   */
  PALPATE_FAULT_OVERFLOW = 6,
  /*
   The device orientation is not a unit quaternion.
   */
  PALPATE_FAULT_ORIENTATION_NOT_UNIT = 7,
  /*
   Of a newer core.
   */
  PALPATE_FAULT_OTHER = 99,
  /*
   There was no tick, since an argument is wrong: the contact, the world, the sample or an array is NULL, a struct_size is
   too small, a number of poses or wrenches is not that of the devices, has_elapsed is neither 0 nor 1, or a reserved number is
   not 0: palpate_last_error.
   */
  PALPATE_FAULT_ARGUMENT = 100,
  /*
   A defect in the library, which has been caught. Report it, please.
   */
  PALPATE_FAULT_INTERNAL = 101,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_fault palpate_fault;
#else
typedef uint32_t palpate_fault;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Why a model was not taken; the one before goes on.
 */
enum palpate_model_refusal
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   It was taken, or none has come.
   */
  PALPATE_MODEL_REFUSAL_NONE = 0,
  /*
   It is of a tick that has not been.
   */
  PALPATE_MODEL_REFUSAL_NOT_YET = 1,
  /*
   It is of a tick before that of the model before.
   */
  PALPATE_MODEL_REFUSAL_OUT_OF_ORDER = 2,
  /*
   It is older than stale_after.
   */
  PALPATE_MODEL_REFUSAL_TOO_OLD = 3,
  /*
   It is of another host.
   */
  PALPATE_MODEL_REFUSAL_OTHER_HOST = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_model_refusal palpate_model_refusal;
#else
typedef uint32_t palpate_model_refusal;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Whether two surfaces touch at a point, and how.
 */
enum palpate_touch
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Apart.
   */
  PALPATE_TOUCH_FREE = 0,
  /*
   They touch, and friction holds, or there is none.
   */
  PALPATE_TOUCH_STICKS = 1,
  /*
   They touch, and slide.
   */
  PALPATE_TOUCH_SLIDES = 2,
  /*
   They overlap but do not push: they part faster than the material follows.
   */
  PALPATE_TOUCH_PARTS = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_touch palpate_touch;
#else
typedef uint32_t palpate_touch;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 On which side of the device the object lies.
 */
enum palpate_side
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   In the direction of increasing device position: penetration = device - object.
   */
  PALPATE_SIDE_POSITIVE = 0,
  /*
   In the direction of decreasing device position: penetration = object - device.
   */
  PALPATE_SIDE_NEGATIVE = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_side palpate_side;
#else
typedef uint32_t palpate_side;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Whether the energy that held forces give out is bounded.
 */
enum palpate_guard
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   It is not.
   */
  PALPATE_GUARD_OFF = 0,
  /*
   A force beyond the bound is held and reported.
   */
  PALPATE_GUARD_REPORT = 1,
  /*
   No force exceeds the bound.
   */
  PALPATE_GUARD_LIMIT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_guard palpate_guard;
#else
typedef uint32_t palpate_guard;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 What palpate_method_text tells of a method.
 */
enum palpate_about_method
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Its name, which `method` of palpate_contact_params takes.
   */
  PALPATE_ABOUT_METHOD_NAME = 0,
  /*
   What it is, in a few words.
   */
  PALPATE_ABOUT_METHOD_SUMMARY = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_about_method palpate_about_method;
#else
typedef uint32_t palpate_about_method;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 What palpate_setting_text tells of a setting.
 */
enum palpate_about_setting
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Its key.
   */
  PALPATE_ABOUT_SETTING_KEY = 0,
  /*
   The symbol of its unit, "" of words, switches and pure numbers.
   */
  PALPATE_ABOUT_SETTING_UNIT = 1,
  /*
   What it is, in words that follow the method's name.
   */
  PALPATE_ABOUT_SETTING_HELP = 2,
  /*
   What is taken where it is not given.
   */
  PALPATE_ABOUT_SETTING_DEFAULT = 3,
  /*
   The words that it takes, with commas between them; "" of one that takes numbers only.
   */
  PALPATE_ABOUT_SETTING_WORDS = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_about_setting palpate_about_setting;
#else
typedef uint32_t palpate_about_setting;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 Limits that changed the force: bits of `limited`.
 */
enum palpate_limit
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   It would have pulled, and the contact may only push.
   */
  PALPATE_LIMIT_PULL = 1,
  /*
   It exceeded the force limit.
   */
  PALPATE_LIMIT_FORCE = 2,
  /*
   It changed faster than the slew limit.
   */
  PALPATE_LIMIT_SLEW = 4,
  /*
   It could give out more energy than there is: the guard's bound.
   */
  PALPATE_LIMIT_GUARD = 8,
  /*
   A torque exceeded the torque limit; of worlds.
   */
  PALPATE_LIMIT_TORQUE = 16,
  /*
   The offset of a tool's avatar was held at its limit; of worlds.
   */
  PALPATE_LIMIT_OFFSET = 32,
  /*
   It was still coming back after a start or a fault; of worlds.
   */
  PALPATE_LIMIT_SOFT_START = 64,
  /*
   No limit but a safety stop: held forces have created energy, and all wrenches stay 0. Free the
   world and make it again to go on; of worlds.
   */
  PALPATE_LIMIT_STOPPED = 128,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_limit palpate_limit;
#else
typedef uint32_t palpate_limit;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 The kind of a shape.
 */
enum palpate_shape_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   A sphere of `radius`; of a tool, a point with radius 0.
   */
  PALPATE_SHAPE_KIND_SPHERE = 0,
  /*
   All that is behind a plane across `normal`, `offset` along it; for fixed bodies.
   */
  PALPATE_SHAPE_KIND_HALF_SPACE = 1,
  /*
   A block of `half_extents`.
   */
  PALPATE_SHAPE_KIND_BOX = 2,
  /*
   All within `radius` of a segment of 2 `half_length` along z.
   */
  PALPATE_SHAPE_KIND_CAPSULE = 3,
  /*
   A cylinder of `radius` and a length of 2 `half_length` along z.
   */
  PALPATE_SHAPE_KIND_CYLINDER = 4,
  /*
   The triangles `faces` between `points`; for bodies.
   */
  PALPATE_SHAPE_KIND_MESH = 5,
  /*
   The convex hull of `points`; for bodies.
   */
  PALPATE_SHAPE_KIND_HULL = 6,
  /*
   A sphere of `radius` at each of `points`; for tools.
   */
  PALPATE_SHAPE_KIND_SPHERES = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_shape_kind palpate_shape_kind;
#else
typedef uint32_t palpate_shape_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 What a joint lets a body do.
 */
enum palpate_joint
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   Turn about the axis, and nothing else.
   */
  PALPATE_JOINT_HINGE = 0,
  /*
   Slide along the axis, and nothing else.
   */
  PALPATE_JOINT_SLIDER = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum palpate_joint palpate_joint;
#else
typedef uint32_t palpate_joint;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 A contact that is rendered; its ticks are in double, or in float where its name ends with f32. One thread at a
 time may use it.
 */
typedef struct palpate_contact_f32 palpate_contact_f32;

/*
 A contact that is rendered; its ticks are in double, or in float where its name ends with f32. One thread at a
 time may use it.
 */
typedef struct palpate_contact palpate_contact;

/*
 What a slow host publishes, as the fast loop renders it: the loop's end. One thread at a time may use it.
 */
typedef struct palpate_local_world palpate_local_world;

/*
 A recording that is being written. One thread at a time may use it.
 */
typedef struct palpate_recorder palpate_recorder;

/*
 What a world is made of: its loop, devices, bodies, laws of contacts and joints. It renders nothing: a world is made of it,
 or changed to it, and knows nothing of it afterwards. One thread at a time may use it.
 */
typedef struct palpate_scene palpate_scene;

/*
 A slow host, such as a physics engine of 60 Hz: the host's end of a local model. One thread at a time may use it.

 The host repeats: take the progress; step over the time since the progress before under palpate_mean_wrench() on each body;
 look for contacts near the avatar; publish its bodies and contacts as of the progress's tick.
 */
typedef struct palpate_low_rate_simulator palpate_low_rate_simulator;

/*
 A world that is rendered. One thread at a time may use it.
 */
typedef struct palpate_world palpate_world;

/*
 A setting of a method, by its key in files: {"damping_n_s_per_m", 0.5, NULL}, or {"placement", 0,
 "false"}.
 */
typedef struct palpate_setting {
  /*
   Its key, such as "damping_n_s_per_m"; palpate_setting_text has those of each method.
   */
  const char *key;
  /*
   Its number, in the unit of the key, where `word` is NULL.
   */
  double number;
  /*
   Its word: one of its own words, "auto", or "true" and "false" of a switch. NULL: the number.
   */
  const char *word;
} palpate_setting;

/*
 One contact between the device's end-point and a virtual object along one axis, and the method that
 renders it. palpate_contact_params_default() fills it.
 */
typedef struct palpate_contact_params {
  /*
   Size of this struct; palpate_contact_params_default() sets it.
   */
  size_t struct_size;
  /*
   Contact stiffness K [N/m], greater than 0. It has no default.
   */
  double stiffness;
  /*
   Mass M of the object [kg], greater than 0. INFINITY, the default: a wall.
   */
  double object_mass;
  /*
   Where the object's surface is at the start, and a wall always [m]. Default: 0.
   */
  double object_position;
  /*
   Its velocity at the start [m/s]; a wall has none. Default: 0.
   */
  double object_velocity;
  /*
   Virtual force f_V on the object, for instance its weight, positive along the axis [N]; that of a
   sample adds to it. Default: 0.
   */
  double virtual_force;
  /*
   Name of the method; palpate_method_text has them all. NULL, the default: coupled rendering.
   */
  const char *method;
  /*
   Settings of the method; what is not given has its default. NULL where there are none.
   */
  const struct palpate_setting *settings;
  /*
   Number of settings.
   */
  size_t setting_count;
  /*
   A palpate_side. Default: PALPATE_SIDE_POSITIVE.
   */
  uint32_t side;
  /*
   1: the contact may only push. Default: 0, as in the paper, whose methods may pull for a part of an
   interval.
   */
  uint32_t unilateral;
} palpate_contact_params;

/*
 The loop, the device in it, and what must never be exceeded. palpate_loop_params_default() fills it.
 */
typedef struct palpate_loop_params {
  /*
   Size of this struct; palpate_loop_params_default() sets it.
   */
  size_t struct_size;
  /*
   Nominal time T between samples [s], greater than 0: 0.001 is 1 ms. It has no default.
   */
  double period;
  /*
   Longest time between two samples that is bridged [s]; a longer one is a fault. 0: 20 periods.
   */
  double largest_gap;
  /*
   Fastest device motion that is believed [m/s]; a faster jump is a fault. INFINITY believes any.
   Default: 100.
   */
  double speed_limit;
  /*
   Largest force that is held [N]. INFINITY: no limit. Default: 20.
   */
  double force_limit;
  /*
   Fastest change of the held force [N/s]. INFINITY, the default: no limit.
   */
  double slew_limit;
  /*
   Time from a sample to the beginning of its force [s], at most 8 periods. Default: 0.
   */
  double delay;
  /*
   Standard deviation of the delay, its changes from command to command included [s].
   */
  double delay_deviation;
  /*
   Time constant of the actuator [s]. Default: 0.
   */
  double lag;
  /*
   Standard deviation of the lag [s].
   */
  double lag_deviation;
  /*
   Delivered over commanded force, greater than 0. Default: 1.
   */
  double gain;
  /*
   Standard deviation of the gain.
   */
  double gain_deviation;
  /*
   Effective mass of the device at its end-point [kg], within a factor of 2; coupled rendering needs
   it. 0, the default: not known. INFINITY: a recording moves the device, and no force can.
   */
  double device_mass;
  /*
   Quantum of the position sensor [m]; 0, the default: not known to have one.
   */
  double encoder_quantum;
  /*
   Fastest device motion against which the guard's bound holds [m/s].
   */
  double guard_speed;
  /*
   Energy that the guard lets be given out beyond the balance [J].
   */
  double guard_allowance;
  /*
   A palpate_guard. Default: PALPATE_GUARD_OFF.
   */
  uint32_t guard;
  /*
   0.
   */
  uint32_t reserved;
} palpate_loop_params;

/*
 One sample of the device. palpate_sample_at() fills it, palpate_sample_f32_at() one in float.
 */
typedef struct palpate_sample {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Measured position of the device's end-point along the contact's axis [m].
   */
  double device_position;
  /*
   Time since the sample before [s], where `has_elapsed` is not 0.
   */
  double elapsed;
  /*
   Virtual force on the object over the coming interval [N], beside that of the contact.
   */
  double virtual_force;
  /*
   1: `elapsed` was measured. 0: one period.
   */
  uint32_t has_elapsed;
  /*
   0.
   */
  uint32_t reserved;
} palpate_sample;

/*
 The answer to a sample, along the contact's axis. palpate_output_empty() makes one to be filled,
 palpate_output_f32_empty() one in float.
 */
typedef struct palpate_output {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Force on the device: what the motor is to be commanded, and to hold until the next sample [N].
   */
  double force_on_device;
  /*
   The same force on the object, opposite in sign [N].
   */
  double force_on_object;
  /*
   Position of the object's surface at this sample [m].
   */
  double object_position;
  /*
   Velocity of the object at this sample [m/s].
   */
  double object_velocity;
  /*
   Penetration of the device into the object at this sample, positive in contact on either side [m].
   */
  double penetration;
  /*
   Instant of the predicted transition, after this sample [s]; 0 where there is none.
   */
  double transition_after;
  /*
   How far coupled rendering has shifted the object over the last interval [m]; a display takes it
   off again.
   */
  double object_shift;
  /*
   What the coming interval is predicted to hold.
   */
  palpate_phase phase;
  /*
   Why the sample was refused.
   */
  palpate_fault fault;
  /*
   Limits that changed the force: bits of palpate_limit.
   */
  uint32_t limited;
  /*
   0.
   */
  uint32_t reserved;
} palpate_output;

/*
 EnergyLedger of the object's energy, positive into the object; they balance at every sample: stored less
 stored at the start = port_work + virtual_force_work + outside_work + held_leak.
 palpate_ledger_empty() makes one to be filled, palpate_ledger_f32_empty() one in float.
 */
typedef struct palpate_ledger {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Kinetic energy of the object and elastic energy of the contact at the last sample [J].
   */
  double stored;
  /*
   Work of the held force on the object's side of the port [J].
   */
  double port_work;
  /*
   Work of the virtual force on the object [J].
   */
  double virtual_force_work;
  /*
   Placing the object anew, other parameters, and what passed while no sample could be trusted [J].
   */
  double outside_work;
  /*
   Energy that the force which was held has created, less what it has destroyed [J].
   */
  double held_leak;
  /*
   The same over the last closed interval [J].
   */
  double held_leak_last;
  /*
   Sum of the absolute leaks of all closed intervals [J].
   */
  double held_leak_absolute;
  /*
   Energy that the plain spring force would have created over the same motion [J].
   */
  double original_leak;
  /*
   The same over the last closed interval [J].
   */
  double original_leak_last;
  /*
   Sum of its absolute leaks over all closed intervals [J].
   */
  double original_leak_absolute;
} palpate_ledger;

/*
 One sample of the device. palpate_sample_at() fills it, palpate_sample_f32_at() one in float.
 */
typedef struct palpate_sample_f32 {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Measured position of the device's end-point along the contact's axis [m].
   */
  float device_position;
  /*
   Time since the sample before [s], where `has_elapsed` is not 0.
   */
  float elapsed;
  /*
   Virtual force on the object over the coming interval [N], beside that of the contact.
   */
  float virtual_force;
  /*
   1: `elapsed` was measured. 0: one period.
   */
  uint32_t has_elapsed;
  /*
   0.
   */
  uint32_t reserved;
} palpate_sample_f32;

/*
 The answer to a sample, along the contact's axis. palpate_output_empty() makes one to be filled,
 palpate_output_f32_empty() one in float.
 */
typedef struct palpate_output_f32 {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Force on the device: what the motor is to be commanded, and to hold until the next sample [N].
   */
  float force_on_device;
  /*
   The same force on the object, opposite in sign [N].
   */
  float force_on_object;
  /*
   Position of the object's surface at this sample [m].
   */
  float object_position;
  /*
   Velocity of the object at this sample [m/s].
   */
  float object_velocity;
  /*
   Penetration of the device into the object at this sample, positive in contact on either side [m].
   */
  float penetration;
  /*
   Instant of the predicted transition, after this sample [s]; 0 where there is none.
   */
  float transition_after;
  /*
   How far coupled rendering has shifted the object over the last interval [m]; a display takes it
   off again.
   */
  float object_shift;
  /*
   What the coming interval is predicted to hold.
   */
  palpate_phase phase;
  /*
   Why the sample was refused.
   */
  palpate_fault fault;
  /*
   Limits that changed the force: bits of palpate_limit.
   */
  uint32_t limited;
  /*
   0.
   */
  uint32_t reserved;
} palpate_output_f32;

/*
 EnergyLedger of the object's energy, positive into the object; they balance at every sample: stored less
 stored at the start = port_work + virtual_force_work + outside_work + held_leak.
 palpate_ledger_empty() makes one to be filled, palpate_ledger_f32_empty() one in float.
 */
typedef struct palpate_ledger_f32 {
  /*
   Size of this struct.
   */
  size_t struct_size;
  /*
   Kinetic energy of the object and elastic energy of the contact at the last sample [J].
   */
  float stored;
  /*
   Work of the held force on the object's side of the port [J].
   */
  float port_work;
  /*
   Work of the virtual force on the object [J].
   */
  float virtual_force_work;
  /*
   Placing the object anew, other parameters, and what passed while no sample could be trusted [J].
   */
  float outside_work;
  /*
   Energy that the force which was held has created, less what it has destroyed [J].
   */
  float held_leak;
  /*
   The same over the last closed interval [J].
   */
  float held_leak_last;
  /*
   Sum of the absolute leaks of all closed intervals [J].
   */
  float held_leak_absolute;
  /*
   Energy that the plain spring force would have created over the same motion [J].
   */
  float original_leak;
  /*
   The same over the last closed interval [J].
   */
  float original_leak_last;
  /*
   Sum of its absolute leaks over all closed intervals [J].
   */
  float original_leak_absolute;
} palpate_ledger_f32;

/*
 The loop, its device, and room for what a slow host publishes. palpate_local_params_default() fills it.
 */
typedef struct palpate_local_params {
  /*
   Size of this struct; palpate_local_params_default() sets it.
   */
  size_t struct_size;
  /*
   Nominal time from sample to sample of the loop, above 0 [s]: 0.001 is 1 ms. It has no default.
   */
  double period;
  /*
   Effective mass of the device along each axis of the world, above 0 [kg]; a factor of 2 is near enough. INFINITY: the device
   lacks this axis. It has no default.
   */
  double device_mass[3];
  /*
   Radius of the tool, a sphere, not below 0 [m]. Default: 0, a point.
   */
  double tool_radius;
  /*
   Age of the newest model beyond which its contacts fade [s]: 1 to 1000 periods of the loop. Default: 0.2.
   */
  double stale_after;
  /*
   Time in which they fade, and come back, above 0 [s]. Default: 0.1.
   */
  double fade;
  /*
   Time in which a change of a contact that touches comes in, above 0 [s]. Default: 0.01.
   */
  double settle;
  /*
   Time in which the loop's copy of a body goes back to the host's body, above 0 [s]. Default: 1.
   */
  double return_time;
  /*
   Quantum of the position sensor, not below 0 [m]. Default: 0.
   */
  double quantum;
  /*
   Time from a sample to the moment at which its command begins to act, not below 0 [s]. Default: 0.
   */
  double delay;
  /*
   Time constant of a first-order lag after it, not below 0 [s]. Default: 0.
   */
  double lag;
  /*
   Delivered over commanded force, above 0. Default: 1.
   */
  double gain;
  /*
   Largest force on the device, by its norm, above 0 [N]. INFINITY: no limit. Default: 20.
   */
  double force_limit;
  /*
   Time over which a force comes in where a start or a recovery finds contact, not below 0 [s]. Default: 0.2.
   */
  double soft_start;
  /*
   Number of the host's bodies, at most 16; 0, the default: contacts with what never moves only.
   */
  uint32_t bodies;
  /*
   Most contacts of a model, 1 to 64. Default: 8.
   */
  uint32_t contacts;
} palpate_local_params;

/*
 Where a device is. It stands in arrays, so it has no struct_size and stays as it is.
 */
typedef struct palpate_pose {
  /*
   Measured position of its tool along the world's axes [m].
   */
  double position[3];
  /*
   Measured orientation, for a device of six axes: a unit quaternion w, x, y, z that turns the tool's axes into those
   of the world. Not looked at for a device of three axes.
   */
  double orientation[4];
} palpate_pose;

/*
 One sample of all devices of a world. palpate_world_sample_at() fills it.
 */
typedef struct palpate_world_sample {
  /*
   Size of this struct; palpate_world_sample_at() sets it.
   */
  size_t struct_size;
  /*
   The devices, in the order of the scene.
   */
  const struct palpate_pose *poses;
  /*
   Number of poses: palpate_world_device_count().
   */
  size_t pose_count;
  /*
   Time since the sample before [s], where `has_elapsed` is not 0.
   */
  double elapsed;
  /*
   1: `elapsed` was measured. 0: one period.
   */
  uint32_t has_elapsed;
  /*
   0.
   */
  uint32_t reserved;
} palpate_world_sample;

/*
 What a device is to give to the hand, and to hold until the next sample. It stands in arrays, so it has no struct_size
 and stays as it is.
 */
typedef struct palpate_wrench {
  /*
   Force along the world's axes [N].
   */
  double force[3];
  /*
   Torque about the tool's centre of mass along the world's axes [N m]; 0 for a device of three axes.
   */
  double torque[3];
} palpate_wrench;

/*
 What a tick by a local model says beside the force. palpate_local_output_empty() makes one to be filled.
 */
typedef struct palpate_local_output {
  /*
   Size of this struct; palpate_local_output_empty() sets it.
   */
  size_t struct_size;
  /*
   Age of the newest model [s]; INFINITY where there is none.
   */
  double age;
  /*
   Why the sample was refused. The force is then 0.
   */
  palpate_fault fault;
  /*
   Limits that changed the force: bits of palpate_limit.
   */
  uint32_t limited;
  /*
   1: the contacts fade, or have faded, because there is no model or it is too old.
   */
  uint32_t is_stale;
  /*
   Why the model that has come since the last tick was not taken.
   */
  palpate_model_refusal refusal;
  /*
   Sub-steps of the tick, with those that were replaced by finer ones.
   */
  uint32_t sub_steps;
  /*
   Sub-steps that were replaced by finer ones, where contacts begin, end, or begin to slip.
   */
  uint32_t refined;
  /*
   Such sub-steps that were not: there were too many of them.
   */
  uint32_t unrefined;
  /*
   1: the fastest contact asked for more sub-steps than a tick may have. A smaller stiffness or a shorter period helps.
   */
  uint32_t too_fast;
} palpate_local_output;

/*
 How far the loop has come: what a host needs for its next step. palpate_progress_empty() makes one to be filled.
 */
typedef struct palpate_progress {
  /*
   Size of this struct; palpate_progress_empty() sets it.
   */
  size_t struct_size;
  /*
   Periods that have passed: those that the loop has rendered, and those that it has missed. A model that has all impulses of this progress in it is of this tick.
   */
  uint64_t tick;
  /*
   Time from sample to sample of the loop [s].
   */
  double period;
  /*
   Where the avatar of the tool is at the end of the last period [m]: where the host looks for what the tool may touch.
   */
  double position[3];
  /*
   Its velocity [m/s].
   */
  double velocity[3];
  /*
   Tick of the newest model, where `has_model` is not 0.
   */
  uint64_t model_tick;
  /*
   1: a model has been taken.
   */
  uint32_t has_model;
  /*
   1: the contacts fade, or have faded, because there is no model or it is too old.
   */
  uint32_t is_stale;
  /*
   Why the last model that came was not taken.
   */
  palpate_model_refusal refusal;
  /*
   0.
   */
  uint32_t reserved;
} palpate_progress;

/*
 What the tool has given to a body of the host. It stands in arrays, so it has no struct_size and stays as it is.
 */
typedef struct palpate_body_progress {
  /*
   Impulse of the tool on the body since the start [N s].
   */
  double impulse[3];
  /*
   Its moment about the body's reference point [N m s].
   */
  double moment[3];
  /*
   Where the loop's copy of the body is [m].
   */
  double copy[3];
} palpate_body_progress;

/*
 A body of a slow host as of a tick, along the world's axes. Its reference point is where the host takes torques about, as a
 rule the centre of mass. It stands in arrays, so it has no struct_size and stays as it is. palpate_host_body_fixed() makes one
 that does not move.
 */
typedef struct palpate_host_body {
  /*
   Where the reference point is, and how the body is turned.
   */
  struct palpate_pose pose;
  /*
   Velocity of the reference point [m/s].
   */
  double velocity[3];
  /*
   Angular velocity [rad/s].
   */
  double angular_velocity[3];
  /*
   Acceleration of the reference point by everything but the tool, over the host's step [m/s^2].
   */
  double acceleration[3];
  /*
   Angular acceleration by everything but the tool [rad/s^2].
   */
  double angular_acceleration[3];
  /*
   What a wrench does to these six: rows are accelerations, columns force [N] and torque about the reference point [N m]. Of a
   free body of mass m, 1/m in the first three places of the diagonal, and the inverse of its inertia in the last three rows
   and columns; of a body that does not move, 0.
   */
  double mobility[6][6];
} palpate_host_body;

/*
 A place where a sphere, the tool or a part of a body, may touch a surface, along the world's axes, with the bodies where the
 model says that they are. The surface is a plane or, with a curvature, a sphere; it is fixed to its body, and has no end. It
 stands in arrays, so it has no struct_size and stays as it is. palpate_host_contact_at_gap() makes one for the tool,
 palpate_host_contact_none() an empty place.
 */
typedef struct palpate_host_contact {
  /*
   A point of the surface: as a rule the one that is nearest to the sphere [m].
   */
  double place[3];
  /*
   Unit vector out of the surface there.
   */
  double normal[3];
  /*
   Curvature of the surface [1/m]: 1/r of a ball of radius r, -1/r of the inside of one, 0 of a plane.
   */
  double curvature;
  /*
   Stiffness, above 0 [N/m]. 0: there is no contact in this place of the array.
   */
  double stiffness;
  /*
   Damping, not below 0 [N s/m].
   */
  double damping;
  /*
   Coefficient of friction, not below 0.
   */
  double friction;
  /*
   Stiffness of friction, above 0 [N/m]; 0: as `stiffness`.
   */
  double friction_stiffness;
  /*
   Damping of friction [N s/m]; 0: `damping` times `friction_stiffness` over `stiffness`; below 0: none.
   */
  double friction_damping;
  /*
   Of a sphere of a body, its centre [m]. Not looked at for the tool.
   */
  double centre[3];
  /*
   Of a sphere of a body, its radius, not below 0 [m]. Not looked at for the tool.
   */
  double radius;
  /*
   Place of the body whose surface is touched; PALPATE_NO_BODY: something that never moves.
   */
  uint32_t on;
  /*
   Place of the body whose sphere touches; PALPATE_NO_BODY: the tool.
   */
  uint32_t of;
} palpate_host_contact;

/*
 What a recording is to have. palpate_recorder_params_default() makes one with every default.
 */
typedef struct palpate_recorder_params {
  /*
   Size of this struct; palpate_recorder_params_default() sets it.
   */
  size_t struct_size;
  /*
   Name of the device, in UTF-8; NULL: not said.
   */
  const char *device;
  /*
   Text of a scene file of what is rendered, in UTF-8, which `palpate replay` of a contact needs; NULL: none.
   */
  const char *scene;
  /*
   Ticks of one contact that may wait for the disk, 1 to 2^24; each takes about 1 KiB, all at once: PALPATE_STATUS_MEMORY where
   the system has not so much. 0: 65536.
   */
  size_t room;
} palpate_recorder_params;

/*
 What a recording had in the end. palpate_recorded_empty() makes one to be filled.
 */
typedef struct palpate_recorded {
  /*
   Size of this struct; palpate_recorded_empty() sets it.
   */
  size_t struct_size;
  /*
   Ticks that the loop made.
   */
  uint64_t ticks_made;
  /*
   Ticks that the file has; 0 where the system refused to write it to its end.
   */
  uint64_t ticks;
  /*
   Ticks that found no room on their way to the disk. The file says which.
   */
  uint64_t lost;
} palpate_recorded;

/*
 What a tick of a world says beside the wrenches. palpate_world_output_empty() makes one to be filled.
 */
typedef struct palpate_world_output {
  /*
   Size of this struct; palpate_world_output_empty() sets it.
   */
  size_t struct_size;
  /*
   Why the sample was refused. Every wrench is then 0.
   */
  palpate_fault fault;
  /*
   The device whose sample is at fault; PALPATE_NO_DEVICE where it is none of one device.
   */
  uint32_t fault_device;
  /*
   Limits that changed a wrench: bits of palpate_limit.
   */
  uint32_t limited;
  /*
   Sub-steps of the tick, with those that were replaced by finer ones.
   */
  uint32_t sub_steps;
  /*
   Sub-steps that were replaced by finer ones, where contacts begin, end, or begin to slip.
   */
  uint32_t refined;
  /*
   Such sub-steps that were not: there were too many of them.
   */
  uint32_t unrefined;
  /*
   1: the fastest contact asked for more sub-steps than a tick may have. A smaller stiffness or a shorter period helps.
   */
  uint32_t too_fast;
  /*
   Triangles of meshes and contacts with them that a sub-step had no room for.
   */
  uint32_t left_out;
} palpate_world_output;

/*
 The loop of a scene, and what methods have for settings. palpate_scene_params_default() fills it.
 */
typedef struct palpate_scene_params {
  /*
   Size of this struct; palpate_scene_params_default() sets it.
   */
  size_t struct_size;
  /*
   Nominal time from sample to sample, above 0 [s]: 0.001 is 1 ms. It has no default.
   */
  double period;
  /*
   Time from a sample to the moment at which its command begins to act, not below 0 [s]. Default: 0.
   */
  double delay;
  /*
   Time constant of a first-order lag after it, not below 0 [s]. Default: 0.
   */
  double lag;
  /*
   Delivered over commanded force, above 0. Default: 1.
   */
  double gain;
  /*
   Damping of the methods that damp [N s/m]; 0, the default: not said.
   */
  double damping;
  /*
   The same of turning [N m s/rad].
   */
  double rotational_damping;
  /*
   Stiffness of virtual-coupling and god-object [N/m]; 0, the default: not said.
   */
  double coupling_stiffness;
  /*
   Mass of the avatar of virtual-coupling [kg]; 0, the default: not said.
   */
  double coupling_mass;
  /*
   The stiffness of its turning [N m/rad].
   */
  double coupling_rotational_stiffness;
  /*
   The moment of inertia of its avatar [kg m^2].
   */
  double coupling_inertia;
} palpate_scene_params;

/*
 A device, as the renderer is told it. palpate_device_params_default() fills it.
 */
typedef struct palpate_device_params {
  /*
   Size of this struct; palpate_device_params_default() sets it.
   */
  size_t struct_size;
  /*
   Effective mass along each axis, above 0 [kg]; a factor of 2 is near enough. It has no default.
   */
  double mass[3];
  /*
   Quantum of the position sensor along each axis, not below 0 [m]. Default: 0.
   */
  double quantum[3];
  /*
   Of a device that measures six axes, its moments of inertia along the tool's axes, above 0 [kg m^2].
   */
  double inertia[3];
  /*
   Of a device that measures six axes, the quantum of its angles, not below 0 [rad]. Default: 0.
   */
  double angle_quantum;
  /*
   1: a device of six axes. 2: one that measures six axes and gives no torque, so that its hand alone turns the tool. 0, the
   default: one of three.
   */
  uint32_t turns;
  /*
   0.
   */
  uint32_t reserved;
} palpate_device_params;

/*
 A shape, in the own axes of the tool or body that has it. palpate_shape_default() fills it. Arrays are copied by the calls
 that take a shape.
 */
typedef struct palpate_shape {
  /*
   Size of this struct; palpate_shape_default() sets it.
   */
  size_t struct_size;
  /*
   One of palpate_shape_kind. Default: PALPATE_SHAPE_KIND_SPHERE.
   */
  uint32_t kind;
  /*
   0.
   */
  uint32_t reserved;
  /*
   Radius [m]. Default: 0.
   */
  double radius;
  /*
   Half of the length of a capsule's segment or a cylinder [m].
   */
  double half_length;
  /*
   Half of a block's length along each axis [m].
   */
  double half_extents[3];
  /*
   Out of a half-space, of any length above 0. Default: z.
   */
  double normal[3];
  /*
   Where a half-space's surface is along its normal [m].
   */
  double offset;
  /*
   Points of a mesh or hull, or centres of spheres: three numbers for each [m].
   */
  const double *points;
  /*
   How many they are.
   */
  size_t point_count;
  /*
   Triangles of a mesh: the places of three points for each, in turn to the left as they are seen from outside.
   */
  const uint32_t *faces;
  /*
   How many they are.
   */
  size_t face_count;
} palpate_shape;

/*
 A body. palpate_body_params_default() fills it.
 */
typedef struct palpate_body_params {
  /*
   Size of this struct; palpate_body_params_default() sets it.
   */
  size_t struct_size;
  /*
   Where it is at the start, and how it is turned: of a body that moves, its centre of mass. Default: the origin.
   */
  struct palpate_pose pose;
  /*
   Mass, above 0 [kg]. INFINITY, the default: a fixed body, which takes no force; one with a velocity is refused.
   */
  double mass;
  /*
   Moments of inertia about the centre of mass along its own axes [kg m^2]. All 0, the default: of its shape, filled evenly.
   */
  double inertia[3];
  /*
   Velocity of the centre of mass at the start [m/s]. Default: 0.
   */
  double velocity[3];
  /*
   Angular velocity at the start along the world's axes [rad/s]. Default: 0.
   */
  double angular_velocity[3];
  /*
   A constant force at the centre of mass, its weight for instance [N]. Default: 0.
   */
  double force[3];
} palpate_body_params;

/*
 The law of a contact: how two surfaces push each other where they overlap, and rub. palpate_contact_law_default() fills it.
 */
typedef struct palpate_contact_law {
  /*
   Size of this struct; palpate_contact_law_default() sets it.
   */
  size_t struct_size;
  /*
   Stiffness, above 0 [N/m]. It has no default.
   */
  double stiffness;
  /*
   Material damping, not below 0 [N s/m]. Default: 0.
   */
  double damping;
  /*
   Coefficient of friction, not below 0. Default: 0.
   */
  double friction;
  /*
   Stiffness of the bristle by which they rub [N/m]. 0, the default: `stiffness`.
   */
  double friction_stiffness;
  /*
   Damping of the bristle [N s/m]. 0, the default: `damping` times `friction_stiffness` over `stiffness`. Below 0: none.
   */
  double friction_damping;
} palpate_contact_law;

/*
 A joint: a bearing of springs, stiff in all directions but one. palpate_joint_params_default() fills it.
 */
typedef struct palpate_joint_params {
  /*
   Size of this struct; palpate_joint_params_default() sets it.
   */
  size_t struct_size;
  /*
   One of palpate_joint.
   */
  uint32_t kind;
  /*
   1: it has stops at `limits`. 0, the default: none.
   */
  uint32_t has_limits;
  /*
   The middle of the bearing, in world axes as the bodies stand when a world is made or changed [m].
   */
  double point[3];
  /*
   Along its axis, of any length above 0. Default: z.
   */
  double axis[3];
  /*
   Stiffness against what it does not let pass, above 0 [N/m]. It has no default.
   */
  double stiffness;
  /*
   The same of damping, not below 0 [N s/m]. Default: 0.
   */
  double damping;
  /*
   Length of the bearing, above 0 [m]. It has no default.
   */
  double span;
  /*
   Stiffness of a spring along or about the axis, not below 0 [N/m], of a hinge [N m/rad]. Default: 0.
   */
  double spring;
  /*
   Where that spring is relaxed [m], of a hinge [rad]. Default: 0, as the bodies stand.
   */
  double rest;
  /*
   Damping along or about the axis, not below 0 [N s/m], of a hinge [N m s/rad]. Default: 0.
   */
  double along_damping;
  /*
   Where its stops are [m], of a hinge [rad].
   */
  double limits[2];
} palpate_joint_params;

/*
 How a world is rendered, where that is not as its scene says. palpate_world_params_default() fills it.
 */
typedef struct palpate_world_params {
  /*
   Size of this struct; palpate_world_params_default() sets it.
   */
  size_t struct_size;
  /*
   Name of the method: basic, virtual-damper, virtual-coupling, god-object or coupled. NULL, the default: the scene's.
   */
  const char *method;
  /*
   Largest force on each device, by its norm [N]. INFINITY: no limit, and none of the torque unless one is given. 0,
   the default: the scene's, or 20 N where it has none.
   */
  double force_limit;
  /*
   Largest torque on each device, by its norm [N m]. INFINITY: no limit. 0, the default: the scene's, or 1 N m where
   it has none.
   */
  double torque_limit;
  /*
   Time over which a force comes in where a start or a recovery finds contact, not below 0 [s]. Default: 0.2.
   */
  double soft_start;
} palpate_world_params;

/*
 A body at the last sample. palpate_body_state_empty() makes one to be filled.
 */
typedef struct palpate_body_state {
  /*
   Size of this struct; palpate_body_state_empty() sets it.
   */
  size_t struct_size;
  /*
   Where its centre of mass is, and how it is turned.
   */
  struct palpate_pose pose;
  /*
   Velocity of its centre of mass [m/s].
   */
  double velocity[3];
  /*
   Angular velocity along the world's axes [rad/s].
   */
  double angular_velocity[3];
} palpate_body_state;

/*
 A point at which two can touch, at the last sample. palpate_contact_state_empty() makes one to be filled.
 */
typedef struct palpate_contact_state {
  /*
   Size of this struct; palpate_contact_state_empty() sets it.
   */
  size_t struct_size;
  /*
   Place of the device of the first of the two; PALPATE_NO_DEVICE where it is a body.
   */
  uint32_t first_device;
  /*
   Place of the body of the first; PALPATE_NO_BODY where it is a device.
   */
  uint32_t first_body;
  /*
   The same of the second.
   */
  uint32_t second_device;
  /*
   The same of the second.
   */
  uint32_t second_body;
  /*
   Whether they touch, and how.
   */
  palpate_touch touch;
  /*
   0.
   */
  uint32_t reserved;
  /*
   Where the force acts [m].
   */
  double point[3];
  /*
   Unit vector from the second to the first.
   */
  double normal[3];
  /*
   Force on the first [N].
   */
  double force[3];
  /*
   How far they overlap, 0 where they do not [m].
   */
  double penetration;
} palpate_contact_state;

/*
 The tool of a device at the last sample. palpate_device_state_empty() makes one to be filled.
 */
typedef struct palpate_device_state {
  /*
   Size of this struct; palpate_device_state_empty() sets it.
   */
  size_t struct_size;
  /*
   Where the device is, by what the method knows.
   */
  struct palpate_pose pose;
  /*
   What the world meets in its place: draw the tool here.
   */
  struct palpate_pose proxy;
  /*
   Velocity of the device [m/s].
   */
  double velocity[3];
  /*
   Velocity of its avatar [m/s].
   */
  double proxy_velocity[3];
} palpate_device_state;

/*
 Sums of a world's books up to the last sample. palpate_world_ledger_empty() makes one to be filled.
 */
typedef struct palpate_world_ledger {
  /*
   Size of this struct; palpate_world_ledger_empty() sets it.
   */
  size_t struct_size;
  /*
   Kinetic energy of the bodies [J].
   */
  double kinetic;
  /*
   Potential energy of the bodies' constant forces, 0 at the start [J].
   */
  double potential;
  /*
   Elastic energy of contacts and joints [J].
   */
  double stored;
  /*
   What damping and friction have taken [J]: never falls.
   */
  double dissipated;
  /*
   Work of the devices' forces on the hands [J].
   */
  double port_work;
  /*
   Energy that held forces have created [J]: what hands, bodies, contacts and dissipation have gained together, and
   nobody has put in.
   */
  double created;
} palpate_world_ledger;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The version of the interface that the library has: that of the header, `PALPATE_ABI_VERSION`, or the
 two do not belong together.
 */
uint32_t palpate_abi_version(void);

/*
 The version of the library, such as "0.1.0".
 */
const char *palpate_version(void);

/*
 Makes a contact, to be freed by palpate_contact_free, and puts it into `*contact`; NULL on an error.
 Not in the library for firmware.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_contact_new(const struct palpate_contact_params *params,
                                   const struct palpate_loop_params *loop_params,
                                   struct palpate_contact **contact);

/*
 Frees a contact of palpate_contact_new. NULL, and a contact in memory of the caller's, are left alone.
 Not in the library for firmware.

 # Safety
 `contact` is NULL or a contact, and is not used afterwards.
 */
void palpate_contact_free(struct palpate_contact *contact);

/*
 Bytes that a contact has.
 */
size_t palpate_contact_size(void);

/*
 A multiple of this is where a contact may begin.
 */
size_t palpate_contact_align(void);

/*
 Makes a contact in `size` bytes of the caller's at `memory`, and puts it into `*contact`; NULL on an
 error. It is there as long as the memory is; nothing has to be freed.

 # Safety
 `memory` is NULL, or `size` bytes can be written there. Each other pointer is NULL or to what its type
 says; structs have the sizes that they begin with.
 */
palpate_status palpate_contact_place(void *memory,
                                     size_t size,
                                     const struct palpate_contact_params *params,
                                     const struct palpate_loop_params *loop_params,
                                     struct palpate_contact **contact);

/*
 One tick: takes a sample and gives the force on the device [N], to be held until the next one.

 It cannot fail: the force is a finite number for any input, and 0 where a sample is refused or an
 argument is wrong. It does not allocate, lock, wait, or loop without bound. `output` may be NULL; where
 it is given, its `fault` says why a sample was refused. Where an argument is wrong, PALPATE_FAULT_ARGUMENT, there was no tick:
 the contact stays as it was.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
double palpate_contact_step(struct palpate_contact *contact,
                            const struct palpate_sample *sample,
                            struct palpate_output *output);

/*
 Says which force on the device was really sent for the last tick [N], where it is another one than
 the tick has given: something between has limited it. What is not finite is refused.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_report_sent(struct palpate_contact *contact, double force_on_device);

/*
 Says which force on the device has really acted since the last sample, in the mean [N], where
 somebody has measured it. What is not finite is refused.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_report_held(struct palpate_contact *contact, double force_on_device);

/*
 Renders something else from the next tick on, without a step in the force: stiffness, mass and
 virtual force pass over to the new ones in 0.1 s, and so does the difference that another method
 makes. The energy of it is booked as outside work. Where the object is does not change: that is
 palpate_contact_teleport. The period and the side stay. On an error all is as it was.

 It does not allocate or wait, so the thread of the loop can call it between two ticks.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_contact_change(struct palpate_contact *contact,
                                      const struct palpate_contact_params *params,
                                      const struct palpate_loop_params *loop_params);

/*
 Puts the object's surface at `position` [m] with the velocity `velocity` [m/s] with the next sample.
 The energy of it is booked as outside work.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_teleport(struct palpate_contact *contact, double position, double velocity);

/*
 Puts the books up to the last sample into `*ledger`.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_contact_ledger(const struct palpate_contact *contact, struct palpate_ledger *ledger);

/*
 Puts what is rendered, in words, into `size` bytes at `memory`, cut to them and ended by a 0. Its
 whole length without the 0; 0 where `contact` is NULL.

 # Safety
 `contact` is NULL or a contact; `memory` is NULL, or `size` bytes can be written there.
 */
size_t palpate_contact_describe(const struct palpate_contact *contact, char *memory, size_t size);

/*
 As palpate_contact_new, in float: the parameters are rounded once. Not in the library for firmware.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_contact_f32_new(const struct palpate_contact_params *params,
                                       const struct palpate_loop_params *loop_params,
                                       struct palpate_contact_f32 **contact);

/*
 As palpate_contact_free, in float. Not in the library for firmware.

 # Safety
 `contact` is NULL or a contact, and is not used afterwards.
 */
void palpate_contact_f32_free(struct palpate_contact_f32 *contact);

/*
 As palpate_contact_size, in float.
 */
size_t palpate_contact_f32_size(void);

/*
 As palpate_contact_align, in float.
 */
size_t palpate_contact_f32_align(void);

/*
 As palpate_contact_place, in float: the parameters are rounded once.

 # Safety
 `memory` is NULL, or `size` bytes can be written there. Each other pointer is NULL or to what its type
 says; structs have the sizes that they begin with.
 */
palpate_status palpate_contact_f32_place(void *memory,
                                         size_t size,
                                         const struct palpate_contact_params *params,
                                         const struct palpate_loop_params *loop_params,
                                         struct palpate_contact_f32 **contact);

/*
 As palpate_contact_step, in float.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
float palpate_contact_f32_step(struct palpate_contact_f32 *contact,
                               const struct palpate_sample_f32 *sample,
                               struct palpate_output_f32 *output);

/*
 As palpate_contact_report_sent, in float.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_f32_report_sent(struct palpate_contact_f32 *contact, float force_on_device);

/*
 As palpate_contact_report_held, in float.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_f32_report_held(struct palpate_contact_f32 *contact, float force_on_device);

/*
 As palpate_contact_change, in float.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_contact_f32_change(struct palpate_contact_f32 *contact,
                                          const struct palpate_contact_params *params,
                                          const struct palpate_loop_params *loop_params);

/*
 As palpate_contact_teleport, in float.

 # Safety
 `contact` is NULL or a contact.
 */
palpate_status palpate_contact_f32_teleport(struct palpate_contact_f32 *contact,
                                            float position,
                                            float velocity);

/*
 As palpate_contact_ledger, in float.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_contact_f32_ledger(const struct palpate_contact_f32 *contact,
                                          struct palpate_ledger_f32 *ledger);

/*
 As palpate_contact_describe, in float.

 # Safety
 `contact` is NULL or a contact; `memory` is NULL, or `size` bytes can be written there.
 */
size_t palpate_contact_f32_describe(const struct palpate_contact_f32 *contact, char *memory, size_t size);

/*
 Fills parameters of a contact with the defaults. `struct_size` is sizeof(palpate_contact_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_contact_params_init(struct palpate_contact_params *params, size_t struct_size);

/*
 What was wrong with the last call that failed: what, which value, and what is allowed, in UTF-8. ""
 before the first one. Each thread has its own; in the library for firmware there is one for the whole
 program. The text is there until the next call that fails, at most as long as its thread.
 */
const char *palpate_last_error(void);

/*
 Makes both ends of a local model, and puts them into `*world` and `*host`; NULL on an error. The loop's end belongs to the
 thread that samples the device, the host's end to the thread of the host; neither ever waits for the other one. Each is to be
 freed, in any order, by palpate_local_world_free and palpate_low_rate_simulator_free.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_local_world_new(const struct palpate_local_params *params,
                                       struct palpate_local_world **world,
                                       struct palpate_low_rate_simulator **host);

/*
 Frees the loop's end of a local model. NULL is allowed.

 # Safety
 `world` is NULL or such an end, and is not used afterwards.
 */
void palpate_local_world_free(struct palpate_local_world *world);

/*
 One tick: takes a sample of the device, with one pose, and puts what it is to hold until the next one into `*wrench`, by the
 newest model that the host has published. The orientation is not looked at, and the torque is 0.

 It cannot fail: the wrench has finite numbers for any input, and is all 0 where a sample is refused or an argument is wrong;
 what it gives says why. It does not allocate, lock, wait, or loop without bound. `output` may be NULL. Where an argument is
 wrong, PALPATE_FAULT_ARGUMENT, there was no tick.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_fault palpate_local_world_step(struct palpate_local_world *world,
                                       const struct palpate_world_sample *sample,
                                       struct palpate_wrench *wrench,
                                       struct palpate_local_output *output);

/*
 Says what was really sent to the device for the last tick, where it is another force than the tick has given: something
 between has limited it. What is not finite is refused.

 # Safety
 Each pointer is NULL or to what its type says.
 */
palpate_status palpate_local_world_report_sent(struct palpate_local_world *world,
                                               const struct palpate_wrench *sent);

/*
 Frees the host's end of a local model. NULL is allowed. What it has published fades in the loop.

 # Safety
 `host` is NULL or such an end, and is not used afterwards.
 */
void palpate_low_rate_simulator_free(struct palpate_low_rate_simulator *host);

/*
 Puts how far the loop has come, as of its last tick, into `*progress`, and what the tool has given to each body into `bodies`,
 of which there are `body_count`: as many as the local model has. Both are of the same tick.

 # Safety
 Each pointer is NULL or to what its type says, `bodies` to `body_count` of them; structs have the sizes that they begin with.
 */
palpate_status palpate_low_rate_simulator_progress(struct palpate_low_rate_simulator *host,
                                          struct palpate_progress *progress,
                                          struct palpate_body_progress *bodies,
                                          size_t body_count);

/*
 Publishes the host's bodies and contacts as of a tick: that of the progress whose impulses the bodies have in them. The loop
 renders by them from its next tick on. A contact is known by its place in `contacts`: the one in the same place of the next
 model is the same contact, which has moved. On an error, which says everything that is wrong, the model before stays. What the
 loop does not take, the next progress says.

 # Safety
 Each pointer is NULL or to what its type says, `bodies` and `contacts` to as many as are said.
 */
palpate_status palpate_low_rate_simulator_publish(struct palpate_low_rate_simulator *host,
                                         uint64_t tick,
                                         const struct palpate_host_body *bodies,
                                         size_t body_count,
                                         const struct palpate_host_contact *contacts,
                                         size_t contact_count);

/*
 Fills parameters of a local model with the defaults. `struct_size` is sizeof(palpate_local_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_local_params_init(struct palpate_local_params *params, size_t struct_size);

/*
 Fills parameters of a loop with the defaults. `struct_size` is sizeof(palpate_loop_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_loop_params_init(struct palpate_loop_params *params, size_t struct_size);

/*
 Number of methods.
 */
size_t palpate_method_count(void);

/*
 Number of settings of method number `method`, counted from 0; 0 where there is no such method.
 */
size_t palpate_method_setting_count(size_t method);

/*
 Puts a text about method number `method`, counted from 0, into `size` bytes at `memory`, cut to them
 and ended by a 0. `what` is a palpate_about_method. Its whole length without the 0; 0 where there
 is no such method or text.

 # Safety
 `memory` is NULL, or `size` bytes can be written there.
 */
size_t palpate_method_text(size_t method, uint32_t what, char *memory, size_t size);

/*
 The same about setting number `setting` of method number `method`. `what` is a
 palpate_about_setting.

 # Safety
 `memory` is NULL, or `size` bytes can be written there.
 */
size_t palpate_setting_text(size_t method, size_t setting, uint32_t what, char *memory, size_t size);

/*
 The name of a palpate_status, such as "struct-size"; "unknown" of any other number. Nobody has to free it.
 */
const char *palpate_status_name(uint32_t status);

/*
 The name of a palpate_fault, such as "gap-too-long", as the files of the program have it; "unknown" of any other number.
 Nobody has to free it.
 */
const char *palpate_fault_name(uint32_t fault);

/*
 Begins the recording of a contact in a new file at `path`, to be ended by palpate_recorder_close, and puts it into
 `*recorder`; NULL on an error, and no file is left then. A file that is there is not replaced. `params` may be NULL: every
 default. Not in the library for firmware.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_recorder_of_contact(const struct palpate_contact *contact,
                                           const char *path,
                                           const struct palpate_recorder_params *params,
                                           struct palpate_recorder **recorder);

/*
 Begins the recording of a world of one device, as palpate_recorder_of_contact does of a contact. `palpate replay` renders
 its motion anew; files of meshes are looked for beside the recording. A world of several devices takes
 palpate_recorder_of_device.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_recorder_of_world(const struct palpate_world *world,
                                         const char *path,
                                         const struct palpate_recorder_params *params,
                                         struct palpate_recorder **recorder);

/*
 Begins the recording of one device of a world, by its place in the scene, with all contacts and bodies of the world. The
 recordings of several devices of a world are several recorders and files; a tick has the same number in each.
 The rest is as for palpate_recorder_of_contact.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_recorder_of_device(const struct palpate_world *world,
                                          size_t device,
                                          const char *path,
                                          const struct palpate_recorder_params *params,
                                          struct palpate_recorder **recorder);

/*
 How many ticks found no room so far, since the disk was slower than the loop; 0 where `recorder` is NULL.

 # Safety
 `recorder` is NULL or a recorder.
 */
uint64_t palpate_recorder_lost(const struct palpate_recorder *recorder);

/*
 Ends a recording: waits until everything is on its way to the disk, writes how many ticks the loop made, and frees the
 recorder, whatever it answers. PALPATE_STATUS_RECORDING where the system refused to write; what was written before can
 be read. `recorded` may be NULL. NULL for a recorder is left alone.

 # Safety
 Each pointer is NULL or to what its type says; the recorder is not used afterwards.
 */
palpate_status palpate_recorder_close(struct palpate_recorder *recorder,
                                      struct palpate_recorded *recorded);

/*
 Fills parameters of a recording with the defaults. `struct_size` is sizeof(palpate_recorder_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_recorder_params_init(struct palpate_recorder_params *params, size_t struct_size);

/*
 Records a tick of the contact that the recorder was made of, after its palpate_contact_step: the sample that went in,
 the output that came out, and the force on the device that was really sent [N]; NaN where nobody knows. A tick of another
 contact is refused.

 It does not allocate, lock or wait, so the thread of the loop can call it: a tick that finds no room is lost and counted.
 Call it once for each tick, refused ones too.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_recorder_contact_tick(struct palpate_recorder *recorder,
                                             const struct palpate_contact *contact,
                                             const struct palpate_sample *sample,
                                             const struct palpate_output *output,
                                             double sent_force);

/*
 Records a tick of the world that the recorder was made of, after its palpate_world_step: the sample that went in, the
 output that came out, and what was really sent to the device that is recorded. A tick of another world is refused, and of
 one that was changed since. The rest is as for palpate_recorder_contact_tick.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_recorder_world_tick(struct palpate_recorder *recorder,
                                           const struct palpate_world *world,
                                           const struct palpate_world_sample *sample,
                                           const struct palpate_world_output *output,
                                           const struct palpate_wrench *sent);

/*
 Makes an empty scene, to be freed by palpate_scene_free, and puts it into `*scene`; NULL on an error. It has no devices, no
 bodies, no laws and no joints yet.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_scene_new(const struct palpate_scene_params *params,
                                 struct palpate_scene **scene);

/*
 Makes the scene of a scene file of format 2, to be changed by calls. The rest is as for palpate_scene_new and
 palpate_world_open.

 # Safety
 Each pointer is NULL or to what its type says.
 */
palpate_status palpate_scene_open(const char *path, struct palpate_scene **scene);

/*
 Frees a scene; worlds that were made of it stay. NULL is left alone.

 # Safety
 `scene` is NULL or a scene, and is not used afterwards.
 */
void palpate_scene_free(struct palpate_scene *scene);

/*
 Adds a device and the shape of its tool: a sphere, several spheres, a box, a capsule or a cylinder. Its place in the scene, which
 samples and wrenches go by, is that of the call. A name may not be "", "*" or "world", nor that of another device or body, and
 has no comma, quotation mark or control character.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_scene_add_device(struct palpate_scene *scene,
                                        const char *name,
                                        const struct palpate_device_params *params,
                                        const struct palpate_shape *shape);

/*
 Adds a body. Its place is that of the call, as long as none before it is removed.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_scene_add_body(struct palpate_scene *scene,
                                      const char *name,
                                      const struct palpate_body_params *params,
                                      const struct palpate_shape *shape);

/*
 Puts what the scene says of a body into `*params`: of a body that moves and is a mesh or hull, its centre of mass.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_scene_body(struct palpate_scene *scene,
                                  const char *name,
                                  struct palpate_body_params *params);

/*
 Says another thing of a body. `shape` may be NULL: it keeps its own. On an error it stays as it was.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_scene_set_body(struct palpate_scene *scene,
                                      const char *name,
                                      const struct palpate_body_params *params,
                                      const struct palpate_shape *shape);

/*
 Takes a body out, with its joints and with the laws that name it. The bodies behind it go down by one place.

 # Safety
 Each pointer is NULL or to what its type says.
 */
palpate_status palpate_scene_remove_body(struct palpate_scene *scene, const char *name);

/*
 Number of bodies of the scene; 0 where `scene` is NULL.

 # Safety
 `scene` is NULL or a scene.
 */
size_t palpate_scene_body_count(struct palpate_scene *scene);

/*
 Number of devices of the scene; 0 where `scene` is NULL.

 # Safety
 `scene` is NULL or a scene.
 */
size_t palpate_scene_device_count(struct palpate_scene *scene);

/*
 Lets two touch by a law, in place of the one that they had: devices and bodies by their names, or "*" for all. A law between
 two names goes before one between a name and "*", which goes before one between "*" and "*". A pair without a law does not
 touch.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_scene_set_law(struct palpate_scene *scene,
                                     const char *one,
                                     const char *other,
                                     const struct palpate_contact_law *law);

/*
 Puts the law between two into `*law`: the one of just these names, or of "*".

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_scene_law(struct palpate_scene *scene,
                                 const char *one,
                                 const char *other,
                                 struct palpate_contact_law *law);

/*
 Takes a law out: the one between just these names, or of "*".

 # Safety
 Each pointer is NULL or to what its type says.
 */
palpate_status palpate_scene_remove_law(struct palpate_scene *scene, const char *one, const char *other);

/*
 Adds a joint of a body with another one, or with the world where `against` is NULL. Its place is that of the call, as long
 as none before it is removed.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_scene_add_joint(struct palpate_scene *scene,
                                       const char *body,
                                       const char *against,
                                       const struct palpate_joint_params *params);

/*
 Says another thing of a joint between the same two. On an error it stays as it was.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_scene_set_joint(struct palpate_scene *scene,
                                       size_t joint,
                                       const struct palpate_joint_params *params);

/*
 Takes a joint out. The joints behind it go down by one place.

 # Safety
 `scene` is NULL or a scene.
 */
palpate_status palpate_scene_remove_joint(struct palpate_scene *scene, size_t joint);

/*
 Number of joints of the scene; 0 where `scene` is NULL.

 # Safety
 `scene` is NULL or a scene.
 */
size_t palpate_scene_joint_count(struct palpate_scene *scene);

/*
 Fills parameters of a scene with the defaults. `struct_size` is sizeof(palpate_scene_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_scene_params_init(struct palpate_scene_params *params, size_t struct_size);

/*
 Fills parameters of a device with the defaults. `struct_size` is sizeof(palpate_device_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_device_params_init(struct palpate_device_params *params, size_t struct_size);

/*
 Fills parameters of a body with the defaults. `struct_size` is sizeof(palpate_body_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_body_params_init(struct palpate_body_params *params, size_t struct_size);

/*
 Fills the law of a contact with the defaults. `struct_size` is sizeof(palpate_contact_law).

 # Safety
 `law` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_contact_law_init(struct palpate_contact_law *law, size_t struct_size);

/*
 Fills parameters of a joint with the defaults. `struct_size` is sizeof(palpate_joint_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_joint_params_init(struct palpate_joint_params *params, size_t struct_size);

/*
 Fills a shape with the defaults. `struct_size` is sizeof(palpate_shape).

 # Safety
 `shape` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_shape_init(struct palpate_shape *shape, size_t struct_size);

/*
 Makes the world of a scene file of format 2, to be freed by palpate_world_free, and puts it into `*world`; NULL on
 an error. Files of meshes are looked for beside the scene. `params` may be NULL: every default.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_world_open(const char *path,
                                  const struct palpate_world_params *params,
                                  struct palpate_world **world);

/*
 Makes a world of the text of a scene of format 2. `name` stands for the path of the scene in messages, and files of
 meshes are looked for beside it; NULL: the working folder. The rest is as for palpate_world_open.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_world_new(const char *scene,
                                 const char *name,
                                 const struct palpate_world_params *params,
                                 struct palpate_world **world);

/*
 Makes the world of a scene, to be freed by palpate_world_free, and puts it into `*world`; NULL on an error. The scene stays as
 it is, and what becomes of it does not change the world. `params` may be NULL: every default.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_world_of_scene(struct palpate_scene *scene,
                                      const struct palpate_world_params *params,
                                      struct palpate_world **world);

/*
 Frees a world. NULL is left alone.

 # Safety
 `world` is NULL or a world, and is not used afterwards.
 */
void palpate_world_free(struct palpate_world *world);

/*
 Goes on with another scene from the next tick on. What is there by its name already goes on from where it is, as it moves:
 what the scene says of its place and velocity is not looked at, but its shape, mass and force, and whether it is fixed, are
 those of the scene. What has another name begins as the scene says, and what is not in the scene is gone. Laws are those of
 the scene. A joint of the same bodies, kind, point, axis and span goes on too; another one begins as the bodies stand. Devices
 have to be the same, in the same order, but for the shapes of their tools; method, period, limits, and what is told of the
 devices stay as they are. On an error all is as it was.

 What the devices are held by passes over in 0.1 s, without a step; the energy of the change is booked as outside work. It
 takes memory, as making a world does, and so long: a tick does not. The places of bodies may be other ones afterwards, names
 that were given are gone, and recorders of the world are to be closed.

 # Safety
 Each pointer is NULL or to what its type says.
 */
palpate_status palpate_world_change(struct palpate_world *world,
                                    struct palpate_scene *scene);

/*
 Puts a body elsewhere from the next tick on, and gives it the velocities of `state`; a fixed one has none. `body` is its
 place. What the devices are held by passes over in 0.1 s, without a step; the energy of it is booked as outside work. It
 takes no memory, so the thread of the loop can call it between two ticks. On an error all is as it was.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_world_place(struct palpate_world *world,
                                   size_t body,
                                   const struct palpate_body_state *state);

/*
 Puts the place of the body of that name into `*body`; it holds until the world is changed.

 # Safety
 Each pointer is NULL or to what its type says.
 */
palpate_status palpate_world_body_named(const struct palpate_world *world, const char *name, size_t *body);

/*
 Number of points at which two of the world can touch, whether they do or not; 0 where `world` is NULL.

 # Safety
 `world` is NULL or a world.
 */
size_t palpate_world_contact_count(const struct palpate_world *world);

/*
 Puts what a point of contact does into `*state`. `contact` is its place, from 0; a world that is changed has other ones.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_world_contact_state(const struct palpate_world *world,
                                           size_t contact,
                                           struct palpate_contact_state *state);

/*
 Puts where the tool of a device is into `*state`. `device` is its place in the scene.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_world_device_state(const struct palpate_world *world,
                                          size_t device,
                                          struct palpate_device_state *state);

/*
 Number of methods for worlds.
 */
size_t palpate_world_method_count(void);

/*
 Name of method number `method` for worlds, counted from 0, which `method` of palpate_world_params takes; NULL where there is
 none. Nobody has to free it.
 */
const char *palpate_world_method_name(size_t method);

/*
 Fills parameters of a world with the defaults. `struct_size` is sizeof(palpate_world_params).

 # Safety
 `params` is NULL, or `struct_size` bytes can be written there.
 */
palpate_status palpate_world_params_init(struct palpate_world_params *params, size_t struct_size);

/*
 Number of devices; 0 where `world` is NULL.

 # Safety
 `world` is NULL or a world.
 */
size_t palpate_world_device_count(const struct palpate_world *world);

/*
 Name of a device by its place in the scene, in UTF-8; NULL where there is none. It lives as long as the world.

 # Safety
 `world` is NULL or a world.
 */
const char *palpate_world_device_name(const struct palpate_world *world,
                                      size_t device);

/*
 1 for a device of six axes, 2 for one that measures six axes and gives no torque, 0 for one of three axes or of another place
 than there are.

 # Safety
 `world` is NULL or a world.
 */
uint32_t palpate_world_device_turns(const struct palpate_world *world,
                                    size_t device);

/*
 Number of bodies, fixed ones too; 0 where `world` is NULL.

 # Safety
 `world` is NULL or a world.
 */
size_t palpate_world_body_count(const struct palpate_world *world);

/*
 Name of a body by its place in the scene, in UTF-8; NULL where there is none. It lives until the world is changed or freed.

 # Safety
 `world` is NULL or a world.
 */
const char *palpate_world_body_name(const struct palpate_world *world,
                                    size_t body);

/*
 Nominal time from sample to sample [s]; 0 where `world` is NULL.

 # Safety
 `world` is NULL or a world.
 */
double palpate_world_period(const struct palpate_world *world);

/*
 Puts where a body is and how it moves into `*state`. `body` is its place in the scene.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_world_body_state(const struct palpate_world *world,
                                        size_t body,
                                        struct palpate_body_state *state);

/*
 Puts the sums of the books up to the last sample into `*ledger`.

 # Safety
 Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
 */
palpate_status palpate_world_ledger_of(const struct palpate_world *world,
                                       struct palpate_world_ledger *ledger);

/*
 One tick: takes a sample of all devices, and puts what each of them is to hold until the next one into `wrenches`, of
 which there are `wrench_count`, one for each device.

 It cannot fail: the wrenches are finite numbers for any input, and all 0 where a sample is refused or an argument is
 wrong; what it gives says why. It does not allocate, lock, wait, or loop without bound. `output` may be NULL. Where an
 argument is wrong, PALPATE_FAULT_ARGUMENT, there was no tick: the world stays as it was.

 # Safety
 Each pointer is NULL or to what its type says, `wrenches` to `wrench_count` of them; structs have the sizes that they
 begin with.
 */
palpate_fault palpate_world_step(struct palpate_world *world,
                                 const struct palpate_world_sample *sample,
                                 struct palpate_wrench *wrenches,
                                 size_t wrench_count,
                                 struct palpate_world_output *output);

/*
 Says what was really sent to a device for the last tick, where it is another wrench than the tick has given: something
 between has limited it. What is not finite is refused.

 # Safety
 Each pointer is NULL or to what its type says.
 */
palpate_status palpate_world_report_sent(struct palpate_world *world,
                                         size_t device,
                                         const struct palpate_wrench *sent);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#ifdef __cplusplus
extern "C" {
#endif

/*
 Given by a firmware, which is the only one that needs it: takes the force off the motors, and does not
 return. A panic of the library would call it; a tick does not panic.
 */
void palpate_panicked(void);

#ifdef __cplusplus
}
#endif

/* Parameters of a loop with every default: no period yet, a force limit of 20 N. */
static inline palpate_loop_params palpate_loop_params_default(void) {
  palpate_loop_params params;
  palpate_loop_params_init(&params, sizeof params);
  return params;
}

/* Parameters of a contact with every default: a wall at 0 m, no stiffness yet. */
static inline palpate_contact_params palpate_contact_params_default(void) {
  palpate_contact_params params;
  palpate_contact_params_init(&params, sizeof params);
  return params;
}

/* A sample at `device_position` [m], one period after the one before. */
static inline palpate_sample palpate_sample_at(double device_position) {
  palpate_sample sample = {sizeof(palpate_sample), device_position, 0.0, 0.0, 0, 0};
  return sample;
}

/* An output to be filled by palpate_contact_step. */
static inline palpate_output palpate_output_empty(void) {
  palpate_output output = {
      sizeof(palpate_output), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, PALPATE_PHASE_WAITING, PALPATE_FAULT_NONE, 0, 0};
  return output;
}

/* palpate_sample_at, in float. */
static inline palpate_sample_f32 palpate_sample_f32_at(float device_position) {
  palpate_sample_f32 sample = {sizeof(palpate_sample_f32), device_position, 0.0f, 0.0f, 0, 0};
  return sample;
}

/* palpate_output_empty, in float. */
static inline palpate_output_f32 palpate_output_f32_empty(void) {
  palpate_output_f32 output = {sizeof(palpate_output_f32), 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f,
                               PALPATE_PHASE_WAITING, PALPATE_FAULT_NONE, 0, 0};
  return output;
}

/* palpate_ledger_empty, in float. */
static inline palpate_ledger_f32 palpate_ledger_f32_empty(void) {
  palpate_ledger_f32 ledger = {
      sizeof(palpate_ledger_f32), 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  return ledger;
}

/* EnergyLedger to be filled by palpate_contact_ledger. */
static inline palpate_ledger palpate_ledger_empty(void) {
  palpate_ledger ledger = {
      sizeof(palpate_ledger), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  return ledger;
}

/* Parameters of a world with every default: as its scene says, a force limit of 20 N where it says none. */
static inline palpate_world_params palpate_world_params_default(void) {
  palpate_world_params params;
  palpate_world_params_init(&params, sizeof params);
  return params;
}

/* A sample of `count` devices, one period after the one before. */
static inline palpate_world_sample palpate_world_sample_at(const palpate_pose *poses, size_t count) {
  palpate_world_sample sample = {sizeof(palpate_world_sample), poses, count, 0.0, 0, 0};
  return sample;
}

/* An output to be filled by palpate_world_step. */
static inline palpate_world_output palpate_world_output_empty(void) {
  palpate_world_output output = {
      sizeof(palpate_world_output), PALPATE_FAULT_NONE, PALPATE_NO_DEVICE, 0, 0, 0, 0, 0, 0};
  return output;
}

/* What a recording is to have, with every default: no name of the device, no scene, room for 65536 ticks. */
static inline palpate_recorder_params palpate_recorder_params_default(void) {
  palpate_recorder_params params;
  palpate_recorder_params_init(&params, sizeof params);
  return params;
}

/* What a recording had in the end, to be filled by palpate_recorder_close. */
static inline palpate_recorded palpate_recorded_empty(void) {
  palpate_recorded recorded = {sizeof(palpate_recorded), 0, 0, 0};
  return recorded;
}

/* A body to be filled by palpate_world_body_state. */
static inline palpate_body_state palpate_body_state_empty(void) {
  palpate_body_state state = {
      sizeof(palpate_body_state), {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  return state;
}

/* Parameters of a scene with every default: no period yet. */
static inline palpate_scene_params palpate_scene_params_default(void) {
  palpate_scene_params params;
  palpate_scene_params_init(&params, sizeof params);
  return params;
}

/* Parameters of a device with every default: three axes, no mass yet. */
static inline palpate_device_params palpate_device_params_default(void) {
  palpate_device_params params;
  palpate_device_params_init(&params, sizeof params);
  return params;
}

/* Parameters of a body with every default: fixed at the origin. */
static inline palpate_body_params palpate_body_params_default(void) {
  palpate_body_params params;
  palpate_body_params_init(&params, sizeof params);
  return params;
}

/* A shape with every default: a point. */
static inline palpate_shape palpate_shape_default(void) {
  palpate_shape shape;
  palpate_shape_init(&shape, sizeof shape);
  return shape;
}

/* A law with every default: no stiffness yet. */
static inline palpate_contact_law palpate_contact_law_default(void) {
  palpate_contact_law law;
  palpate_contact_law_init(&law, sizeof law);
  return law;
}

/* Parameters of a joint with every default: a hinge about z at the origin, no stiffness and no span yet. */
static inline palpate_joint_params palpate_joint_params_default(void) {
  palpate_joint_params params;
  palpate_joint_params_init(&params, sizeof params);
  return params;
}

/* A point of contact to be filled by palpate_world_contact_state. */
static inline palpate_contact_state palpate_contact_state_empty(void) {
  palpate_contact_state state = {sizeof(palpate_contact_state),
                                 PALPATE_NO_DEVICE,
                                 PALPATE_NO_BODY,
                                 PALPATE_NO_DEVICE,
                                 PALPATE_NO_BODY,
                                 PALPATE_TOUCH_FREE,
                                 0,
                                 {0.0, 0.0, 0.0},
                                 {0.0, 0.0, 0.0},
                                 {0.0, 0.0, 0.0},
                                 0.0};
  return state;
}

/* A tool to be filled by palpate_world_device_state. */
static inline palpate_device_state palpate_device_state_empty(void) {
  palpate_device_state state = {sizeof(palpate_device_state),
                                {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}},
                                {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}},
                                {0.0, 0.0, 0.0},
                                {0.0, 0.0, 0.0}};
  return state;
}

/* Parameters of a local model with every default: no period and no mass of the device yet. */
static inline palpate_local_params palpate_local_params_default(void) {
  palpate_local_params params;
  palpate_local_params_init(&params, sizeof params);
  return params;
}

/* An output to be filled by palpate_local_world_step. */
static inline palpate_local_output palpate_local_output_empty(void) {
  palpate_local_output output = {
      sizeof(palpate_local_output), 0.0, PALPATE_FAULT_NONE, 0, 0, PALPATE_MODEL_REFUSAL_NONE, 0, 0, 0, 0};
  return output;
}

/* A progress to be filled by palpate_low_rate_simulator_progress. */
static inline palpate_progress palpate_progress_empty(void) {
  palpate_progress progress = {sizeof(palpate_progress), 0, 0.0, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0, 0, 0,
                               PALPATE_MODEL_REFUSAL_NONE, 0};
  return progress;
}

/* The mean wrench of the tool on a body over `time` [s], between two progresses: what the host holds over its step. None where no
   time has passed. */
static inline palpate_wrench palpate_mean_wrench(const palpate_body_progress *then, const palpate_body_progress *now,
                                                 double time) {
  palpate_wrench wrench = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  int axis;
  for (axis = 0; axis < 3 && time > 0.0; axis++) {
    wrench.force[axis] = (now->impulse[axis] - then->impulse[axis]) / time;
    wrench.torque[axis] = (now->moment[axis] - then->moment[axis]) / time;
  }
  return wrench;
}

/* A body of a slow host that is at rest at x, y, z [m], not turned, and that nothing moves. */
static inline palpate_host_body palpate_host_body_fixed(double x, double y, double z) {
  palpate_host_body body = {{{x, y, z}, {1.0, 0.0, 0.0, 0.0}},
                            {0.0, 0.0, 0.0},
                            {0.0, 0.0, 0.0},
                            {0.0, 0.0, 0.0},
                            {0.0, 0.0, 0.0},
                            {{0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                             {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}}};
  return body;
}

/* No contact in this place of the array. */
static inline palpate_host_contact palpate_host_contact_none(void) {
  palpate_host_contact contact = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
                                  {0.0, 0.0, 0.0}, 0.0, PALPATE_NO_BODY, PALPATE_NO_BODY};
  return contact;
}

/* A contact of the tool with a flat surface of the body at place `on`, or of PALPATE_NO_BODY: by the signed `gap` [m] between the
   surface and the tool, a sphere of `radius` [m], when the tool's centre is at `centre` [m], which is what most engines answer to
   a query. Below 0 they overlap. `normal` is a unit vector out of the surface. There is no damping and no friction yet. */
static inline palpate_host_contact palpate_host_contact_at_gap(const double centre[3], double radius, uint32_t on, double gap,
                                                               const double normal[3], double stiffness) {
  palpate_host_contact contact = palpate_host_contact_none();
  int axis;
  for (axis = 0; axis < 3; axis++) {
    contact.place[axis] = centre[axis] - normal[axis] * (gap + radius);
    contact.normal[axis] = normal[axis];
  }
  contact.stiffness = stiffness;
  contact.on = on;
  return contact;
}

/* EnergyLedger to be filled by palpate_world_ledger_of. */
static inline palpate_world_ledger palpate_world_ledger_empty(void) {
  palpate_world_ledger ledger = {sizeof(palpate_world_ledger), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  return ledger;
}
