// Integrators: eight things side by side move as each would alone.
#include "tests/unit/physics/integrator_test.h"
#include "shared/core/rng.h"

#include <bit>

namespace zoned::physics {
namespace {

using Eight = Eigen::Array<float, 8, 3>;

/// A ball in air for one vector, and the same for eight.
struct Air {
    float drag = 0.05F;

    Vec3 operator()(const Vec3& x, const Vec3& v, float t) const {
        const float speed = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        const float share = -drag * speed;
        return {share * v[0] - x[0], share * v[1] - 9.81F, share * v[2] + t};
    }

    void jacobian(const Vec3&, const Vec3& v, float, Mat3& dx, Mat3& dv) const {
        const float speed = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        dx.setZero();
        dx(0, 0) = -1.0F;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                dv(i, j) = -drag * (v[i] * v[j] / speed + (i == j ? speed : 0.0F));
            }
        }
    }
};

struct AirForEight {
    Air air;

    Eight operator()(const Eight& x, const Eight& v, float t) const {
        Eight out;
        for (int k = 0; k < 8; ++k) {
            out.row(k) = air(x.row(k).transpose(), v.row(k).transpose(), t).transpose().array();
        }
        return out;
    }

    void jacobian(const Eight& x,
                  const Eight& v,
                  float t,
                  JacobianOf<Eight>& dx,
                  JacobianOf<Eight>& dv) const {
        for (int k = 0; k < 8; ++k) {
            Mat3 dx1;
            Mat3 dv1;
            air.jacobian(x.row(k).transpose(), v.row(k).transpose(), t, dx1, dv1);
            for (int i = 0; i < 3; ++i) {
                dx.block<1, 3>(k, 3 * i) = dx1.row(i).array();
                dv.block<1, 3>(k, 3 * i) = dv1.row(i).array();
            }
        }
    }
};

struct Starts {
    Eight x;
    Eight v;

    Starts() {
        core::Rng rng(5);
        for (int k = 0; k < 8; ++k) {
            for (int i = 0; i < 3; ++i) {
                x(k, i) = rng.range(-5, 5);
                v(k, i) = rng.range(-30, 30) * (k == 3 ? 0.001F : 1.0F);
            }
        }
    }
};

bool same_bits(float a, float b) {
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

template <class Lanes, class Alone>
void expect_same(IntegratorKind kind, const Lanes& lanes, const Alone& alone, bool exactly) {
    constexpr float kH = 1.0F / 30;
    Starts s;
    const Starts start;
    with_integrator<Eight>(kind, [&](auto method) {
        method.start(s.x, s.v, 0.0F, kH, lanes);
        for (int i = 0; i < 50; ++i) {
            method.step(s.x, s.v, static_cast<float>(i) * kH, kH, lanes);
        }
    });
    for (int k = 0; k < 8; ++k) {
        Vec3 x = start.x.row(k).transpose();
        Vec3 v = start.v.row(k).transpose();
        with_integrator<Vec3>(kind, [&](auto method) {
            method.start(x, v, 0.0F, kH, alone);
            for (int i = 0; i < 50; ++i) {
                method.step(x, v, static_cast<float>(i) * kH, kH, alone);
            }
        });
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(s.x(k, i), x[i], 1e-4F) << name_of(kind) << " " << k;
            EXPECT_TRUE(!exactly || same_bits(s.x(k, i), x[i])) << name_of(kind) << " " << k;
            EXPECT_TRUE(!exactly || same_bits(s.v(k, i), v[i])) << name_of(kind) << " " << k;
        }
    }
}

/// Bit for bit, but for the adaptive pair, whose pieces are cut for all eight.
TEST(Integrators, MoveEightSideBySideAsEachAlone) {
    const Air air;
    for (const IntegratorKind kind : kIntegratorKinds) {
        expect_same(kind, AirForEight{air}, air, kind != IntegratorKind::kAdaptive);
    }
}

TEST(ImplicitEuler, MovesEightAsEachAloneWithDerivativesItIsNotTold) {
    const Air air;
    const AirForEight eight{air};
    expect_same(
        IntegratorKind::kImplicitEuler,
        [&](const Eight& x, const Eight& v, float t) { return eight(x, v, t); },
        [&](const Vec3& x, const Vec3& v, float t) { return air(x, v, t); },
        true);
}

TEST(Integrators, TakeOneColumnOfEight) {
    using Column = Eigen::Array<float, 8, 1>;
    const auto spring = [](const Column& x, const Column& v, float) {
        return Column(-4.0F * x - 0.5F * v);
    };
    const scenario::SwayingSpring same{2.0, 0.125, 0.0, 0.0};
    const auto exact = same.exact({scenario::Line(1.0), scenario::Line(0.0)}, 1.0);
    for (const IntegratorKind kind : kIntegratorKinds) {
        Column x = Column::LinSpaced(0.0F, 7.0F);
        Column v = Column::Zero();
        with_integrator<Column>(kind, [&](auto method) {
            method.start(x, v, 0.0F, 1.0F / 256, spring);
            for (int i = 0; i < 256; ++i) {
                method.step(x, v, static_cast<float>(i) / 256, 1.0F / 256, spring);
            }
        });
        for (int k = 0; k < 8; ++k) {
            // Methods of order one are off by about omega h / 2 = 0.4 % of the amplitude and phase.
            EXPECT_NEAR(x[k], static_cast<float>(k * exact.x[0]), 0.01F * static_cast<float>(k))
                << name_of(kind);
        }
    }
}

}  // namespace
}  // namespace zoned::physics
