// Inverse dynamics of a linkage with Pinocchio in C++, one crank angle after the other, as its user writes it: Newton's method on the
// Jacobian of the loops, rates and accelerations from the same Jacobian, `rnea`, and the passive rows for the forces of the loops.
//
// Loops are points that coincide, a pin two of them on its axis. Matrices are row by row. SI units, world axes.

#include <pinocchio/multibody.hpp>

#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <cmath>
#include <vector>

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Vector3 = Eigen::Vector3d;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double CLOSED = 1e-13;  // largest gap of a loop [m]
constexpr double RANK = 1e-9;     // share of the largest singular value below which an equation says nothing new
constexpr int MOST_NEWTON_STEPS = 20;

struct Point {  // two points that coincide, in the frames of the joints that carry them; 0 is the frame
  int joint[2];
  Vector3 at[2];
};

struct Press {
  pinocchio::Model model;
  pinocchio::Data data;
  std::vector<Point> points;
  std::vector<int> kept;  // rows of the loops' equations that have an effect: in the plane two of three
  std::vector<int> passive;
  int driver = 0;
  bool square = false;
  Matrix whole, dependent;  // Jacobian of all rows and joints, and of the kept rows and passive joints
  Vector driven;
  Eigen::PartialPivLU<Matrix> lu;
  Eigen::CompleteOrthogonalDecomposition<Matrix> orthogonal;

  Vector3 place(const Point& point, int end) const { return data.oMi[point.joint[end]].act(point.at[end]); }

  // Places of all joints, gaps of the loops, and their Jacobian, at joint coordinates.
  double load(const Vector& q, Vector& gaps) {
    pinocchio::computeJointJacobians(model, data, q);
    whole.setZero();
    Vector all(3 * points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      for (int end = 0; end < 2; ++end) {
        const double sign = end ? 1.0 : -1.0;
        const Vector3 at = place(points[k], end);
        for (int j = points[k].joint[end]; j > 0; j = int(model.parents[j])) {
          const auto column = data.J.col(j - 1);
          whole.block<3, 1>(3 * k, j - 1) += sign * (column.head<3>() + column.tail<3>().cross(at));
        }
      }
      all.segment<3>(3 * k) = place(points[k], 1) - place(points[k], 0);
    }
    for (std::size_t r = 0; r < kept.size(); ++r) {
      gaps[r] = all[kept[r]];
      driven[r] = whole(kept[r], driver);
      for (std::size_t c = 0; c < passive.size(); ++c) dependent(r, c) = whole(kept[r], passive[c]);
    }
    return all.cwiseAbs().maxCoeff();
  }

  void factor() {
    if (square) lu.compute(dependent);
    else orthogonal.compute(dependent);
  }

  Vector solve(const Vector& right) const { return square ? Vector(lu.solve(right)) : Vector(orthogonal.solve(right)); }
  Vector solve_transposed(const Vector& right) const {
    return square ? Vector(lu.transpose().solve(right)) : Vector(orthogonal.transpose().solve(right));
  }

  bool close(Vector& q) {
    Vector gaps(kept.size());
    for (int step = 0; step < MOST_NEWTON_STEPS; ++step) {
      const double open = load(q, gaps);
      factor();
      if (!std::isfinite(open)) return false;
      if (open < CLOSED) return true;
      const Vector change = solve(gaps);
      for (std::size_t c = 0; c < passive.size(); ++c) q[passive[c]] -= change[c];
    }
    return false;
  }

  // Acceleration of one end of a loop, from velocities and accelerations of the joints that were computed last.
  Vector3 acceleration(const Point& point, int end) const {
    const int j = point.joint[end];
    const auto &v = data.v[j], &a = data.a[j];
    const Vector3 velocity = v.linear() + v.angular().cross(point.at[end]);
    return data.oMi[j].rotation() * (a.linear() + a.angular().cross(point.at[end]) + v.angular().cross(velocity));
  }

  void set_passive(Vector& all, const Vector& some) const {
    for (std::size_t c = 0; c < passive.size(); ++c) all[passive[c]] = some[c];
  }
};

template <typename X, typename Y, typename Z, typename Unaligned>
pinocchio::JointIndex add_joint(pinocchio::Model& model, int parent, const pinocchio::SE3& place, const Vector3& axis) {
  if (axis == Vector3::UnitX()) return model.addJoint(parent, X(), place, "joint" + std::to_string(model.njoints));
  if (axis == Vector3::UnitY()) return model.addJoint(parent, Y(), place, "joint" + std::to_string(model.njoints));
  if (axis == Vector3::UnitZ()) return model.addJoint(parent, Z(), place, "joint" + std::to_string(model.njoints));
  return model.addJoint(parent, Unaligned(axis), place, "joint" + std::to_string(model.njoints));
}

}  // namespace

#define EXPORTED extern "C" __attribute__((visibility("default")))

// A press: of every joint its parent, whether it turns, its axis (3), rotation (9) and place (3) in its parent, and its body's mass, centre
// (3) and inertia about it (9); of every point the two joints and the two places (3) in their frames; the driver; closed coordinates.
EXPORTED void* create_press(int joints, const int* parents, const int* turns, const double* axes, const double* rotations,
                            const double* places, const double* masses, const double* centres, const double* inertias,
                            const double* gravity, int points, const int* ends, const double* ats, int driver, const double* closed) {
  using namespace pinocchio;
  Press* press = new Press;
  Model& model = press->model;
  model.gravity.linear() = Eigen::Map<const Vector3>(gravity);
  for (int j = 0; j < joints; ++j) {
    const SE3 place(Eigen::Map<const RowMajor3>(rotations + 9 * j), Eigen::Map<const Vector3>(places + 3 * j));
    const Vector3 axis = Eigen::Map<const Vector3>(axes + 3 * j);
    const JointIndex made =
        turns[j] ? add_joint<JointModelRX, JointModelRY, JointModelRZ, JointModelRevoluteUnaligned>(model, parents[j], place, axis)
                 : add_joint<JointModelPX, JointModelPY, JointModelPZ, JointModelPrismaticUnaligned>(model, parents[j], place, axis);
    const Eigen::Matrix3d about = Eigen::Map<const RowMajor3>(inertias + 9 * j);
    model.appendBodyToJoint(made, Inertia(masses[j], Eigen::Map<const Vector3>(centres + 3 * j), about), SE3::Identity());
    if (j != driver) press->passive.push_back(j);
  }
  press->data = Data(model);
  for (int k = 0; k < points; ++k) {
    const Eigen::Map<const Vector3> at1(ats + 6 * k), at2(ats + 6 * k + 3);
    press->points.push_back(Point{{ends[2 * k], ends[2 * k + 1]}, {at1, at2}});
  }
  press->driver = driver;
  press->whole.resize(3 * points, joints);
  Vector none(0);
  press->load(Eigen::Map<const Vector>(closed, joints), none);
  for (int row = 0; row < 3 * points; ++row)
    if (press->whole.row(row).cwiseAbs().maxCoeff() > RANK) press->kept.push_back(row);
  press->square = press->kept.size() == press->passive.size();
  press->dependent.resize(press->kept.size(), joints - 1);
  press->driven.resize(press->kept.size());
  press->orthogonal.setThreshold(RANK);
  return press;
}

EXPORTED void delete_press(void* press) { delete static_cast<Press*>(press); }

// Driving torque (n) and forces (n, joints + points, 3): of parent on child in the open tree, then of end 1 on end 2, at crank angles (n)
// and a speed, from joint coordinates near the first angle. Returns the number of angles done, less than n where the loops are not closed.
EXPORTED int inverse_dynamics(void* handle, int n, const double* angles, double speed, const double* start, double* torque, double* force) {
  using namespace pinocchio;
  Press& press = *static_cast<Press*>(handle);
  const Model& model = press.model;
  Data& data = press.data;
  const int nv = model.nv, carried = nv + int(press.points.size());
  Vector q = Eigen::Map<const Vector>(start, nv), v = Vector::Zero(nv), a = Vector::Zero(nv), drift(press.kept.size()), passive(nv - 1);
  const Vector still = Vector::Zero(nv);
  for (int i = 0; i < n; ++i) {
    const double time = i ? (angles[i] - angles[i - 1]) / speed : 0.0;
    q += time * v + 0.5 * time * time * a;
    q[press.driver] = angles[i];
    if (!press.close(q)) return i;
    press.set_passive(v, press.solve(press.driven * -speed));
    v[press.driver] = speed;
    forwardKinematics(model, data, q, v, still);
    Vector all(3 * press.points.size());
    for (std::size_t k = 0; k < press.points.size(); ++k)
      all.segment<3>(3 * k) = press.acceleration(press.points[k], 1) - press.acceleration(press.points[k], 0);
    for (std::size_t r = 0; r < press.kept.size(); ++r) drift[r] = -all[press.kept[r]];
    a[press.driver] = 0.0;
    press.set_passive(a, press.solve(drift));

    const Vector& effort = rnea(model, data, q, v, a);  // = torque on the driver + Jacobian' multipliers, which act on end 2
    for (std::size_t c = 0; c < press.passive.size(); ++c) passive[c] = effort[press.passive[c]];
    const Vector multipliers = press.solve_transposed(passive);
    torque[i] = effort[press.driver] - press.driven.dot(multipliers);

    Eigen::Map<Eigen::Matrix<double, 3, Eigen::Dynamic>> forces(force + 3 * carried * i, 3, carried);
    for (int j = 1; j <= nv; ++j) forces.col(j - 1) = data.oMi[j].rotation() * data.f[j].linear();
    forces.rightCols(press.points.size()).setZero();
    for (std::size_t r = 0; r < press.kept.size(); ++r) forces(press.kept[r] % 3, nv + press.kept[r] / 3) = multipliers[r];
  }
  return n;
}
