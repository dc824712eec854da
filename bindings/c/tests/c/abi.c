/* Sizes, alignments and field offsets of the structs on 64-bit machines, which every library of this ABI must keep for
   compiled programs. src/abi.rs asserts the same of the Rust side. */
#include <palpate.h>

#define HAS(type, size, align)                                                \
  _Static_assert(sizeof(type) == (size), "another size of " #type);           \
  _Static_assert(_Alignof(type) == (align), "another alignment of " #type);   \
  _Static_assert(offsetof(type, struct_size) == 0, "struct_size comes first")
#define AT(type, field, place) _Static_assert(offsetof(type, field) == (place), "another place of " #field)

_Static_assert(PALPATE_ABI_VERSION == 1, "the numbers below are those of version 1");
_Static_assert(sizeof(palpate_status) == 4, "another size of palpate_status");
_Static_assert(sizeof(palpate_phase) == 4, "another size of palpate_phase");
_Static_assert(sizeof(palpate_fault) == 4, "another size of palpate_fault");

#if UINTPTR_MAX == UINT64_MAX
_Static_assert(sizeof(palpate_setting) == 24, "another size of palpate_setting");
HAS(palpate_contact_params, 80, 8);
AT(palpate_contact_params, virtual_force, 40);
AT(palpate_contact_params, setting_count, 64);
AT(palpate_contact_params, unilateral, 76);
HAS(palpate_loop_params, 176, 8);
AT(palpate_loop_params, force_limit, 32);
AT(palpate_loop_params, delay, 48);
AT(palpate_loop_params, device_mass, 96);
AT(palpate_loop_params, guard, 160);
AT(palpate_loop_params, hold, 164);
HAS(palpate_sample, 40, 8);
AT(palpate_sample, has_elapsed, 32);
HAS(palpate_output, 88, 8);
AT(palpate_output, slope_on_device, 24);
AT(palpate_output, proxy_shift, 64);
AT(palpate_output, phase, 72);
AT(palpate_output, limited, 80);
HAS(palpate_ledger, 88, 8);
AT(palpate_ledger, held_leak, 40);
HAS(palpate_sample_f32, 32, 8);
AT(palpate_sample_f32, has_elapsed, 20);
HAS(palpate_output_f32, 56, 8);
AT(palpate_output_f32, slope_on_device, 16);
AT(palpate_output_f32, proxy_shift, 36);
AT(palpate_output_f32, phase, 40);
AT(palpate_output_f32, limited, 48);
HAS(palpate_ledger_f32, 48, 8);
AT(palpate_ledger_f32, held_leak, 24);
_Static_assert(sizeof(palpate_pose) == 56, "another size of palpate_pose");
_Static_assert(sizeof(palpate_wrench) == 72, "another size of palpate_wrench");
HAS(palpate_world_params, 40, 8);
AT(palpate_world_params, force_limit, 16);
AT(palpate_world_params, soft_start, 32);
HAS(palpate_world_sample, 40, 8);
AT(palpate_world_sample, pose_count, 16);
AT(palpate_world_sample, has_elapsed, 32);
HAS(palpate_world_output, 40, 8);
AT(palpate_world_output, limited, 16);
AT(palpate_world_output, left_out, 36);
HAS(palpate_body_state, 112, 8);
AT(palpate_body_state, velocity, 64);
AT(palpate_body_state, angular_velocity, 88);
HAS(palpate_local_params, 136, 8);
AT(palpate_local_params, device_mass, 16);
AT(palpate_local_params, stale_after, 48);
AT(palpate_local_params, quantum, 80);
AT(palpate_local_params, force_limit, 112);
AT(palpate_local_params, bodies, 128);
HAS(palpate_local_output, 48, 8);
AT(palpate_local_output, fault, 16);
AT(palpate_local_output, refusal, 28);
AT(palpate_local_output, too_fast, 44);
HAS(palpate_progress, 96, 8);
AT(palpate_progress, position, 24);
AT(palpate_progress, model_tick, 72);
AT(palpate_progress, refusal, 88);
_Static_assert(sizeof(palpate_host_body) == 440, "another size of palpate_host_body");
AT(palpate_host_body, mobility, 152);
_Static_assert(sizeof(palpate_host_contact) == 136, "another size of palpate_host_contact");
AT(palpate_host_contact, on, 128);
_Static_assert(sizeof(palpate_body_progress) == 72, "another size of palpate_body_progress");
AT(palpate_body_progress, copy, 48);
_Static_assert(sizeof(palpate_model_refusal) == 4, "another size of palpate_model_refusal");
HAS(palpate_world_ledger, 56, 8);
AT(palpate_world_ledger, created, 48);
HAS(palpate_scene_params, 96, 8);
AT(palpate_scene_params, gain, 32);
AT(palpate_scene_params, coupling_inertia, 80);
AT(palpate_scene_params, hold, 88);
HAS(palpate_guard_params, 96, 8);
AT(palpate_guard_params, acceleration, 40);
AT(palpate_guard_params, late_samples, 88);
AT(palpate_guard_params, mode, 92);
HAS(palpate_device_params, 96, 8);
AT(palpate_device_params, inertia, 56);
AT(palpate_device_params, turns, 88);
HAS(palpate_body_params, 168, 8);
AT(palpate_body_params, mass, 64);
AT(palpate_body_params, velocity, 96);
AT(palpate_body_params, force, 144);
HAS(palpate_shape, 120, 8);
AT(palpate_shape, radius, 16);
AT(palpate_shape, normal, 56);
AT(palpate_shape, points, 88);
AT(palpate_shape, face_count, 112);
HAS(palpate_contact_law, 48, 8);
AT(palpate_contact_law, friction_stiffness, 32);
AT(palpate_contact_law, friction_damping, 40);
HAS(palpate_joint_params, 128, 8);
AT(palpate_joint_params, kind, 8);
AT(palpate_joint_params, point, 16);
AT(palpate_joint_params, stiffness, 64);
AT(palpate_joint_params, limits, 112);
HAS(palpate_contact_state, 112, 8);
AT(palpate_contact_state, touch, 24);
AT(palpate_contact_state, point, 32);
AT(palpate_contact_state, penetration, 104);
_Static_assert(sizeof(palpate_touch) == 4, "another size of palpate_touch");
HAS(palpate_device_state, 168, 8);
AT(palpate_device_state, proxy, 64);
AT(palpate_device_state, velocity, 120);
HAS(palpate_recorder_params, 32, 8);
AT(palpate_recorder_params, scene, 16);
AT(palpate_recorder_params, room, 24);
HAS(palpate_recorded, 32, 8);
AT(palpate_recorded, lost, 24);
#endif

int main(void) { return 0; }
