#include "server/store/store.h"

namespace zoned::store {

namespace {

struct SizeOf {
    static std::size_t of(const StoreKey& key) {
        return key.account.size() + key.character.size() + key.key.size();
    }

    std::size_t operator()(const PutRecord& c) const { return of(c.key) + c.value.size(); }

    std::size_t operator()(const RemoveRecord& c) const { return of(c.key); }

    std::size_t operator()(const ForgetRecords& c) const { return c.account.size(); }

    std::size_t operator()(const NoteLogin& c) const {
        return c.account.size() + c.character.size();
    }

    std::size_t operator()(const PutStand& c) const {
        return c.account.size() + c.character.size() + c.place.world.size();
    }

    std::size_t operator()(const PutBan& c) const { return c.account.size() + c.reason.size(); }

    std::size_t operator()(const RemoveBan& c) const { return c.account.size(); }

    std::size_t operator()(const UseTicket& c) const { return c.nonce.size(); }

    std::size_t operator()(const ForgetTickets&) const { return 0; }

    std::size_t operator()(const AddEvent& c) const {
        return c.account.size() + c.topic.size() + c.payload.size();
    }
};

}  // namespace

std::size_t size_of(const StoreChange& change) {
    return sizeof(StoreChange) + std::visit(SizeOf{}, change);
}

}  // namespace zoned::store
