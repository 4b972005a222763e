#include "server/zone/context/stop_context.h"

#include "server/zone/zone_state.h"

#include <utility>

namespace zoned::zone {

bool StopContext::store_put(const mailbox::StoreKey& key, Bytes value) {
    return ask(mailbox::StoreAct::kPut, key, std::move(value));
}

bool StopContext::store_remove(const mailbox::StoreKey& key) {
    return ask(mailbox::StoreAct::kRemove, key, {});
}

bool StopContext::ask(mailbox::StoreAct act, const mailbox::StoreKey& key, Bytes value) {
    if (!may_ask_store(*out_, key, value)) {
        return false;
    }
    mailbox::StoreRequest& request = out_->store.emplace_back();
    request.act = act;
    request.zone = context_.zone();
    request.key = key;
    request.value = std::move(value);
    return true;
}

}  // namespace zoned::zone
