// ContactColoring: sorts contacts into colours whose contacts share no moving body.
#pragma once

#include "server/physics/contacts/contact_graph.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::physics {

/// Contacts of one colour may be solved in any order, or eight at a time, with the same result.
/// Greedy: each contact in turn gets the lowest colour that neither body has yet (first fit; at
/// most the sum of both bodies' contacts minus one colours). Within a colour, contacts with the
/// same number of points stand together, so that few lanes idle.
class ContactColoring {
  public:
    /// Up to this many colours; a contact that finds none of them free gets a group of its own.
    static constexpr std::uint32_t kColors = 64;

    struct ColorGroup {
        std::uint32_t begin = 0;
        std::uint32_t end = 0;
    };

    void reserve(std::size_t bodies, std::size_t contacts);

    /// `solver_slot` of the contacts' awake bodies must be set, below `slots`; bodies that take no
    /// impulses do not bind a contact to a colour.
    void build(const Bodies& bodies,
               const ContactGraph& graph,
               std::span<const std::uint32_t> list,
               std::size_t slots);

    /// The contacts in the order in which they are to be solved.
    [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }

    /// Ranges of at most eight contacts in `order()`, all of one colour.
    [[nodiscard]] const std::vector<ColorGroup>& groups() const { return groups_; }

    /// Ranges of groups whose contacts share no moving body: the colours, and each contact that
    /// found none.
    [[nodiscard]] const std::vector<ColorGroup>& stages() const { return stages_; }

  private:
    static constexpr std::size_t kClasses = (kColors + 1) * (kMaxManifoldPoints + 1);

    std::vector<std::uint64_t> taken_;  // by slot: colours in use
    std::vector<std::uint16_t> class_;  // by place in the list: colour and number of points
    std::vector<std::uint32_t> order_;
    std::vector<ColorGroup> groups_;
    std::vector<ColorGroup> stages_;
    std::array<std::uint32_t, kClasses + 1> first_{};
};

}  // namespace zoned::physics
