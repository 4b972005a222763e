// ContactRows: contacts as rows of a RowSystem, and their impulses back into the contacts.
#pragma once

#include "server/physics/contacts/contact_graph.h"
#include "server/physics/settings/variant_settings.h"
#include "server/physics/solver_variants/rows/row_system.h"
#include "server/physics/solver_variants/rows/variant_bodies.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::physics {

/// The numbers that all rows of a substep share.
struct RowParameters {
    const VariantSettings* settings = nullptr;
    double h = 0.0;                  ///< length of the substep, s
    double gravity = 0.0;            ///< m/s2
    double restitution_speed = 0.0;  ///< slower impacts do not bounce, m/s
    bool guess = false;              ///< impulses of the last solve are the first guess
    bool bounces = true;             ///< restitution as a bias; else it is left to the response
};

/// A contact among the rows: normal rows first, then friction.
struct ContactSpan {
    std::uint32_t contact = 0;
    std::uint32_t first = 0;  ///< row
    std::uint8_t points = 0;  ///< of the manifold
    bool divided = false;
    bool rubs = false;  ///< has rows of friction
    Vec3d tangent1 = Vec3d::Zero(), tangent2 = Vec3d::Zero();
    std::array<double, kMaxManifoldPoints> share{};  ///< of the load, sum 1
    std::array<Vec3d, kMaxManifoldPoints> lever{};   ///< from the middle of the load, m
};

class ContactRows {
  public:
    void reserve(std::size_t contacts) { spans_.reserve(contacts); }

    void clear() { spans_.clear(); }

    /// Appends the rows of a contact between the bodies in slots a and b.
    void write(const Bodies& bodies,
               const ContactGraph& graph,
               std::uint32_t contact,
               const VariantBodies& moving,
               const RowParameters& parameters,
               RowSystem& system);
    /// Writes impulses back; `add`: step_impulse grows by them, else it starts from them.
    void store(const RowSystem& system, double h, bool add, ContactGraph& graph) const;

    [[nodiscard]] const std::vector<ContactSpan>& spans() const { return spans_; }

  private:
    struct Site;
    static void place(const Bodies& bodies,
                      const Pair& pair,
                      const Contact& contact,
                      const VariantBodies& moving,
                      const RowSystem& system,
                      Site& site);
    /// Over which distance, m, a divided load goes over from the nearest point to all.
    static double spread_of(const Site& site, double h);
    static void share_load(const Site& site, const RowParameters& parameters, ContactSpan& span);
    static void write_normal(const Site& site,
                             const Vec3d& arm_a,
                             const Vec3d& arm_b,
                             double gap,
                             double lambda,
                             const RowParameters& parameters,
                             RowSystem& system);
    static void write_points(const Site& site,
                             const ContactSpan& span,
                             const RowParameters& parameters,
                             RowSystem& system);
    static void write_divided(const Site& site,
                              const ContactSpan& span,
                              const RowParameters& parameters,
                              RowSystem& system);
    static void store_friction(const RowSystem& system, const ContactSpan& span, Contact& contact);

    std::vector<ContactSpan> spans_;
};

}  // namespace zoned::physics
