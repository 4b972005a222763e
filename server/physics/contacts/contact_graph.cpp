#include "server/physics/contacts/contact_graph.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <bit>

namespace zoned::physics {

namespace {

constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

}  // namespace

bool ContactGraph::contains(std::uint32_t a, std::uint32_t b) const {
    const std::uint64_t key = key_of(a, b);
    for (std::size_t slot = home_of(key);; slot = (slot + 1) & (keys_.size() - 1)) {
        if (keys_[slot] == key) {
            return true;
        }
        if (keys_[slot] == kEmpty) {
            return false;
        }
    }
}

void ContactGraph::grow_keys() {
    std::vector<std::uint64_t> old(keys_.size() * 2, kEmpty);
    old.swap(keys_);
    for (const std::uint64_t key : old) {
        if (key != kEmpty) {
            std::size_t slot = home_of(key);
            while (keys_[slot] != kEmpty) {
                slot = (slot + 1) & (keys_.size() - 1);
            }
            keys_[slot] = key;
        }
    }
}

void ContactGraph::reserve(std::size_t contacts) {
    pairs_.reserve(contacts);
    pool_.reserve(contacts);
    free_.reserve(contacts);
    active_.reserve(contacts);
    while (keys_.size() < 2 * contacts) {
        grow_keys();
    }
}

void ContactGraph::insert_key(std::uint64_t key) {
    if (2 * (static_cast<std::size_t>(size_) + 1) > keys_.size()) {
        grow_keys();
    }
    std::size_t slot = home_of(key);
    while (keys_[slot] != kEmpty) {
        slot = (slot + 1) & (keys_.size() - 1);
    }
    keys_[slot] = key;
}

/// Linear probing without tombstones: keys behind the gap move up (Knuth, TAOCP vol. 3, section
/// 6.4, algorithm R).
void ContactGraph::erase_key(std::uint64_t key) {
    const std::size_t mask = keys_.size() - 1;
    std::size_t gap = home_of(key);
    while (keys_[gap] != key) {
        gap = (gap + 1) & mask;
    }
    for (std::size_t slot = (gap + 1) & mask; keys_[slot] != kEmpty; slot = (slot + 1) & mask) {
        const std::size_t home = home_of(keys_[slot]);
        if (((slot - home) & mask) >= ((slot - gap) & mask)) {
            keys_[gap] = keys_[slot];
            gap = slot;
        }
    }
    keys_[gap] = kEmpty;
}

void ContactGraph::link(Bodies& bodies,
                        std::uint32_t contact,
                        std::uint32_t side,
                        std::uint32_t row) {
    const Link head = bodies.first_contact[row];
    pool_[contact].next[side] = head;
    pool_[contact].previous[side] = kNoIndex;
    if (head != kNoIndex) {
        pool_[head >> 1].previous[head & 1] = contact * 2 + side;
    }
    bodies.first_contact[row] = contact * 2 + side;
}

void ContactGraph::unlink(Bodies& bodies,
                          std::uint32_t contact,
                          std::uint32_t side,
                          std::uint32_t row) {
    const Link next = pool_[contact].next[side];
    const Link previous = pool_[contact].previous[side];
    if (next != kNoIndex) {
        pool_[next >> 1].previous[next & 1] = previous;
    }
    if (previous != kNoIndex) {
        pool_[previous >> 1].next[previous & 1] = next;
    } else {
        bodies.first_contact[row] = next;
    }
}

std::uint32_t ContactGraph::take() {
    if (!free_.empty()) {
        const std::uint32_t index = free_.back();
        free_.pop_back();
        pool_[index] = Contact();
        pairs_[index] = Pair();
        return index;
    }
    const auto index = static_cast<std::uint32_t>(pool_.size());
    pool_.emplace_back();
    pairs_.emplace_back();
    // Reserved together with the pool, so that steps that only shuffle contacts about never
    // allocate.
    free_.reserve(pool_.capacity());
    active_.reserve(pool_.capacity());
    return index;
}

std::uint32_t ContactGraph::create(Bodies& bodies, std::uint32_t a, std::uint32_t b) {
    const std::uint32_t index = take();
    insert_key(key_of(a, b));
    ++size_;
    pairs_[index].a = std::min(a, b);
    pairs_[index].b = std::max(a, b);
    link(bodies, index, 0, pairs_[index].a);
    link(bodies, index, 1, pairs_[index].b);
    if (bodies.simulated(a) || bodies.simulated(b)) {
        activate(index);
    }
    return index;
}

std::uint32_t ContactGraph::make_record(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t index = take();
    pairs_[index].a = a;
    pairs_[index].b = b;
    return index;
}

void ContactGraph::drop_chain(std::uint32_t contact) {
    for (std::uint32_t at = pool_[contact].chain; at != kNoIndex;) {
        const std::uint32_t next = pool_[at].chain;
        drop_record(at);
        at = next;
    }
    pool_[contact].chain = kNoIndex;
}

void ContactGraph::destroy(Bodies& bodies, std::uint32_t contact) {
    deactivate(contact);
    drop_chain(contact);
    const std::uint32_t a = pairs_[contact].a;
    const std::uint32_t b = pairs_[contact].b;
    unlink(bodies, contact, 0, a);
    unlink(bodies, contact, 1, b);
    erase_key(key_of(a, b));
    --size_;
    free_.push_back(contact);
}

void ContactGraph::activate(std::uint32_t contact) {
    if (pairs_[contact].active_place == kNoIndex) {
        pairs_[contact].active_place = static_cast<std::uint32_t>(active_.size());
        active_.push_back(contact);
    }
}

void ContactGraph::deactivate(std::uint32_t contact) {
    const std::uint32_t place = pairs_[contact].active_place;
    if (place == kNoIndex) {
        return;
    }
    const std::uint32_t last = active_.back();
    active_[place] = last;
    pairs_[last].active_place = place;
    active_.pop_back();
    pairs_[contact].active_place = kNoIndex;
}

bool ContactGraph::is_sound() const {
    const std::size_t records = pool_.size();
    const auto here = [records](std::uint32_t index) {
        return index == kNoIndex || index < records;
    };
    const auto linked = [records](std::uint32_t link) {
        return link == kNoIndex || (link >> 1) < records;
    };
    bool sound = pairs_.size() == records && size_ <= records &&
                 std::has_single_bit(keys_.size()) && 2 * std::size_t{size_} < keys_.size();
    for (std::size_t i = 0; sound && i < records; ++i) {
        const Pair& pair = pairs_[i];
        const Contact& contact = pool_[i];
        sound = linked(contact.next[0]) && linked(contact.next[1]) && linked(contact.previous[0]) &&
                linked(contact.previous[1]) && here(contact.chain) &&
                pair.points() <= static_cast<std::size_t>(kMaxManifoldPoints);
    }
    for (const auto* list : {&free_, &active_}) {
        for (std::size_t i = 0; sound && i < list->size(); ++i) {
            sound = (*list)[i] < records;
        }
    }
    for (std::size_t i = 0; sound && i < active_.size(); ++i) {
        sound = pairs_[active_[i]].active_place == i;
    }
    return sound;
}

}  // namespace zoned::physics
