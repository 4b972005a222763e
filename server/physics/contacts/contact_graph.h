// ContactGraph: the pairs whose bounding boxes overlap, and their state between steps.
#pragma once

#include "server/physics/bodies/bodies.h"
#include "server/physics/narrowphase/contact_set.h"
#include "server/physics/narrowphase/manifold.h"

#include <array>
#include <cstdint>
#include <vector>

namespace zoned::physics {

/// The state that one contact point carries from step to step.
struct ContactPoint {
    Vec3 arm_a =
        Vec3::Zero();  ///< from a's centre to the point, world axes, at the time of contact
    Vec3 arm_b = Vec3::Zero();
    float separation = 0.0F;
    float found_separation = 0.0F;  ///< when the narrowphase last looked
    float impulse = 0.0F;           ///< normal, per substep, N s: the warm start
    std::uint32_t feature = 0;
};

/// The poses of a pair at its last test. The result holds as long as neither body has turned, or
/// moved notably relative to the other.
struct FoundAt {
    /// No point has been left out that the surfaces could bring together by coming nearer by this,
    /// m; negative: nothing is known.
    float reach = -1.0F;
    Vec3 between = Vec3::Zero();  ///< from a's centre to b's
    Quat orientation_a = Quat::Identity();
    Quat orientation_b = Quat::Identity();
};

/// The part of a pair that each step asks for. Most pairs are near and do not touch: they cost one
/// cache line.
struct alignas(64) Pair {
    std::uint32_t a = kNoIndex;  ///< body rows, a < b
    std::uint32_t b = kNoIndex;
    std::uint32_t active_place = kNoIndex;  ///< in ContactGraph::active
    std::uint8_t count : 4 = 0;             ///< contact points
    std::uint8_t several : 1 = 0;  ///< its manifolds are in a chain of records; it has no points
    std::uint8_t sensor : 1 = 0;   ///< one of the two is a sensor: it never has points
    std::uint8_t senses : 1 = 0;   ///< a sensor has the other within it, as of the last look
    std::uint8_t inside : 1 = 0;   ///< ... as of the last event
    bool touching = false;         ///< after the last step in which it was looked at
    bool closing = false;          ///< touches or will within the step
    std::uint8_t age = 0;          ///< steps in a row that it has had points for, up to 255
    FoundAt found;

    [[nodiscard]] std::size_t points() const { return count; }

    template <class Archive>
    void serialize(Archive& archive) {
        std::uint8_t points_here = count;
        bool is_several = several != 0;
        bool is_sensor = sensor != 0;
        bool is_sensing = senses != 0;
        bool is_inside = inside != 0;
        archive(a, b, active_place, points_here, is_several, is_sensor, is_sensing, is_inside);
        archive(touching, closing, age, found);
        count = points_here & 0xFU;
        several = is_several ? 1U : 0U;
        sensor = is_sensor ? 1U : 0U;
        senses = is_sensing ? 1U : 0U;
        inside = is_inside ? 1U : 0U;
    }
};

static_assert(sizeof(Pair) == 64);

/// The state that a pair with contact points carries from step to step.
struct Contact {
    std::array<std::uint32_t, 2> next{kNoIndex, kNoIndex};  ///< per side, in the body's list
    std::array<std::uint32_t, 2> previous{kNoIndex, kNoIndex};
    std::array<ContactPoint, kMaxManifoldPoints> points;
    Vec3 normal = Vec3::UnitY();  ///< from a to b
    Vec3 lead = Vec3::Zero();  ///< how far b has to move relative to a until the contact, negated
    Vec3 friction = Vec3::Zero();    ///< impulse per substep, world: the warm start
    Vec3 rolling = Vec3::Zero();     ///< moment against rolling and spinning, likewise, N m s
    float carried = 0.0F;            ///< normal impulse per point and substep, low-passed, N s
    float twist = 0.0F;              ///< friction's moment about the normal, N m s
    float substep_s = 0.0F;          ///< length of the substeps that the impulses are of
    float approach_speed = 0.0F;     ///< m/s, before the solve
    float step_impulse = 0.0F;       ///< sum of normal impulses in the last step, N s
    Grip grip;                       ///< of the touching surfaces
    PartKey part = 0;                ///< in a chain: which parts of the shapes meet
    std::uint32_t chain = kNoIndex;  ///< first record of the chain; in one: the next
};

/// Contacts in a pool with stable indices. Each body has a linked list of its contacts; those in
/// which an awake dynamic body takes part are listed in `active`. A pair with several manifolds has
/// no points itself but a chain of further records, which are in no list; it touches when one of
/// them does.
class ContactGraph {
  public:
    /// Reference to one side of a contact: index * 2 + side.
    using Link = std::uint32_t;

    [[nodiscard]] bool contains(std::uint32_t a, std::uint32_t b) const;
    /// The pair must not be there yet. Links it to both bodies; active when one is simulated.
    std::uint32_t create(Bodies& bodies, std::uint32_t a, std::uint32_t b);
    void destroy(Bodies& bodies, std::uint32_t contact);

    /// A record between two bodies that is in no list and no chain yet; drop_record gives it back.
    std::uint32_t make_record(std::uint32_t a, std::uint32_t b);

    void drop_record(std::uint32_t record) { free_.push_back(record); }

    /// Calls visit(index of a record) for a contact and its chain.
    template <class Visit>
    void for_chain(std::uint32_t contact, Visit&& visit) const {
        visit(contact);
        if (pairs_[contact].several != 0) {
            for (std::uint32_t at = pool_[contact].chain; at != kNoIndex; at = pool_[at].chain) {
                visit(at);
            }
        }
    }

    /// Makes room for that many contacts.
    void reserve(std::size_t contacts);

    void activate(std::uint32_t contact);
    void deactivate(std::uint32_t contact);

    Contact& operator[](std::uint32_t contact) { return pool_[contact]; }

    Pair& pair(std::uint32_t contact) { return pairs_[contact]; }

    const Pair& pair(std::uint32_t contact) const { return pairs_[contact]; }

    const Contact& operator[](std::uint32_t contact) const { return pool_[contact]; }

    [[nodiscard]] const std::vector<std::uint32_t>& active() const { return active_; }

    [[nodiscard]] std::uint32_t size() const { return size_; }

    /// Indexes are below it.
    [[nodiscard]] std::size_t records() const { return pool_.size(); }

    /// Calls visit(contact index, row of the other body) for each contact of a body. The visitor
    /// may destroy the contact that it is given.
    template <class Visit>
    void for_each_of(const Bodies& bodies, std::uint32_t row, Visit&& visit) const {
        for (Link link = bodies.first_contact[row]; link != kNoIndex;) {
            const Contact& contact = pool_[link >> 1];
            const Link next = contact.next[link & 1];
            visit(link >> 1, (link & 1) == 0 ? pairs_[link >> 1].b : pairs_[link >> 1].a);
            link = next;
        }
    }

    /// The pool as it is, its order and its gaps: they decide the order of later contacts.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(pairs_, pool_, free_, active_, keys_, size_);
        if constexpr (Archive::kReads) {
            if (!is_sound()) {
                archive.fail("contacts name others that there are not");
            }
        }
    }

  private:
    /// Whether all numbers name records that there are.
    [[nodiscard]] bool is_sound() const;

    static std::uint64_t key_of(std::uint32_t a, std::uint32_t b) {
        return (static_cast<std::uint64_t>(a < b ? a : b) << 32) | (a < b ? b : a);
    }

    [[nodiscard]] std::size_t home_of(std::uint64_t key) const {
        key *= 0x9E3779B97F4A7C15ull;
        return (key ^ (key >> 29)) & (keys_.size() - 1);
    }

    std::uint32_t take();
    void drop_chain(std::uint32_t contact);
    void grow_keys();
    void insert_key(std::uint64_t key);
    void erase_key(std::uint64_t key);
    void link(Bodies& bodies, std::uint32_t contact, std::uint32_t side, std::uint32_t row);
    void unlink(Bodies& bodies, std::uint32_t contact, std::uint32_t side, std::uint32_t row);

    std::vector<Pair> pairs_;
    std::vector<Contact> pool_;
    std::vector<std::uint32_t> free_;
    std::vector<std::uint32_t> active_;
    std::vector<std::uint64_t> keys_ = std::vector<std::uint64_t>(256, ~std::uint64_t{0});
    std::uint32_t size_ = 0;
};

}  // namespace zoned::physics
