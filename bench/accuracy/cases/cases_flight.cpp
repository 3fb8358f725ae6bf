// One body that meets nobody: free fall, drag, free spin. Errors relative to the way travelled.
#include <cmath>

#include "cases/case.h"
#include "closed_forms.h"

namespace psim::accuracy {
namespace {

constexpr double kFall = 10;   // s
constexpr double kDrag = 0.5;  // 1/s
constexpr double kDragTime = 2;
constexpr double kQuadratic = 0.05;  // 1/m
constexpr double kSpin = 100;        // rad/s
constexpr double kSpinTime = 10;

Case free_fall() {
  Case c;
  c.name = "free-fall";
  c.shows = "a disc thrown sideways falls for 10 s";
  c.quantities = {{"free-fall", "of the way", "analytic", {{4, 1e-5}}}};
  c.scene = [] {
    Scene scene = open_scene(2000);
    scene.bodies = {disc({0, 1000}, {3, 0}, material(0))};
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(kFall);
    const BodyState& s = run.body(0);
    const double y = reference::fall_height(1000, 0, kGravity, kFall);
    return {std::hypot(s.x - 3 * kFall, s.y - y) / (1000 - y)};
  };
  return c;
}

Case linear_drag() {
  Case c;
  c.name = "drag";
  c.shows = "a throw of 10 m/s each way with linear drag 0.5/s, after 2 s";
  c.quantities = {{"drag", "of the way", "analytic", {{4, 1e-5}}}};
  c.scene = [] {
    Scene scene = open_scene(100);
    scene.world.linear_damping = kDrag;
    scene.bodies = {disc({0, 0}, {10, 10}, material(0))};
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(kDragTime);
    const auto truth = reference::linear_drag_position({10, 10}, kGravity, kDrag, kDragTime);
    const BodyState& s = run.body(0);
    return {std::hypot(s.x - truth.x, s.y - truth.y) / reference::length(truth)};
  };
  return c;
}

Case quadratic_drag() {
  Case c;
  c.name = "quadratic-drag";
  c.shows = "a fall from rest with quadratic drag 0.05/m, after 2 s";
  c.quantities = {{"quadratic-drag", "of the way", "analytic", {{4, 1e-4}}}};
  c.scene = [] {
    Scene scene = open_scene(100);
    scene.world.fields = {DragField{0, kQuadratic}};
    scene.bodies = {disc({0, 50}, {0, 0}, material(0))};
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(kDragTime);
    const double drop = reference::quadratic_drag_drop(kGravity, kQuadratic, kDragTime);
    return {std::abs((50 - run.body(0).y) / drop - 1)};
  };
  return c;
}

Case free_spin() {
  Case c;
  c.name = "spin";
  c.shows = "a disc turns freely at 100 rad/s for 10 s";
  c.quantities = {{"spin", "of the angle", "analytic", {{4, 1e-4}}}};
  c.scene = [] {
    Scene scene = open_scene(100, {0, 0});
    BodyDesc body = disc({0, 0}, {0, 0}, material(0, 0.5));
    body.angular_velocity = kSpin;
    scene.bodies = {body};
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(kSpinTime);
    return {std::abs(run.body(0).angle / (kSpin * kSpinTime) - 1)};
  };
  return c;
}

}  // namespace

std::vector<Case> flight_cases(Effort) { return {free_fall(), linear_drag(), quadratic_drag(), free_spin()}; }

}  // namespace psim::accuracy
