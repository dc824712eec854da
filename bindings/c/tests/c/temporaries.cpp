/*
 * Functions whose result points to an array reject a temporary one: the file compiles without CASE, and a deleted
 * overload rejects each CASE.
 */
#include <array>
#include <vector>

#include "palpate.hpp"

#if __cplusplus >= 202002L
#include <span>
#endif

inline std::vector<palpate_setting> settings() { return {{"damping_n_s_per_m", 0.5, nullptr}}; }
inline std::vector<palpate_pose> poses() { return std::vector<palpate_pose>(1); }
inline std::vector<double> points() { return {0, 0, 0, 1, 0, 0, 0, 1, 0}; }

int main() {
  auto params = palpate::contact_params(1000.0);
  const std::vector<palpate_setting> kept_settings = settings();
  const std::array<palpate_pose, 1> kept_poses{};
  const std::vector<double> kept_points = points();
  const std::uint32_t kept_faces[] = {0, 1, 2};
  (void)kept_faces;
#ifndef CASE
  palpate::use(params, kept_settings);
  palpate::use(params, {kept_settings.data(), 1});
  palpate::use(params, palpate::span<const palpate_setting>(kept_settings));
  palpate::world_sample(kept_poses);
  palpate::hull(kept_points);
  palpate::hull(palpate::span<const double>(kept_points).first(3));
  palpate::mesh(kept_points, kept_faces);
  palpate::mesh(palpate::span<const double>(kept_points), kept_faces);
  palpate::mesh({kept_points.data(), 9}, {kept_faces, 3});
#if __cplusplus >= 202002L
  palpate::hull(std::span(kept_points));
  palpate::mesh(std::span(kept_points), std::span(kept_faces));
#endif
#elif CASE == 1
  palpate::use(params, settings());
#elif CASE == 2
  palpate::use(params, {{"damping_n_s_per_m", 0.5, nullptr}});
#elif CASE == 3
  palpate::world_sample(poses());
#elif CASE == 4
  palpate::world_sample({palpate_pose{}});
#elif CASE == 5
  palpate::hull(points());
#elif CASE == 6
  palpate::hull({0.0, 0.0, 0.0, 1.0, 0.0, 0.0});
#elif CASE == 7
  palpate::mesh(points(), kept_faces);
#elif CASE == 8
  palpate::mesh(kept_points, std::array<std::uint32_t, 3>{0, 1, 2});
#elif CASE == 9
  palpate::mesh(kept_points, {0u, 1u, 2u});
#elif CASE == 10
  palpate::mesh({0.0, 0.0, 0.0}, kept_faces);
#elif CASE == 11
  palpate::use(params, std::move(kept_settings));
#endif
}
