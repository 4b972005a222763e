#include "tests/harness/virtual_server.h"

#include "server/app/runtime/host_settings.h"
#include "server/app/world/world.h"
#include "server/app/world/world_rules.h"
#include "server/config/expand/load_settings.h"
#include "server/config/settings.h"
#include "server/session/host/session_host.h"
#include "server/store/store_service.h"
#include "tests/harness/virtual_transport.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace zoned::harness {

namespace {

config::Settings load(const VirtualServerSettings& settings) {
    config::Settings config;
    std::vector<config::ConfigError> errors;
    const bool good = settings.config_is_text
                          ? config::parse_settings(settings.config, settings.sets, config, errors)
                          : config::load_settings(settings.config, settings.sets, config, errors);
    if (!good) {
        throw std::runtime_error(config::format_errors("config", errors));
    }
    app::declare_fields(config);
    return config;
}

}  // namespace

VirtualServer::VirtualServer(const VirtualServerSettings& settings)
    : settings_(settings),
      config_(std::make_unique<config::Settings>(load(settings))),
      world_(std::make_unique<app::World>(*config_, settings.threads)),
      host_(std::make_unique<session::SessionHost>(app::host_settings(*config_), output())) {
    host_->set_udp_port(1);
    if (settings_.records == nullptr) {
        settings_.records = std::make_shared<Records>();
    }
}

VirtualServer::~VirtualServer() = default;

void VirtualServer::wrap_rules(const WrapRules& wrap) {
    for (const auto& zone : world_->zones()) {
        std::unique_ptr<zone::Rules>& rules = zone->state().rules;
        rules = wrap(std::move(rules));
    }
}

std::unique_ptr<link::Transport> VirtualServer::connect() {
    return std::make_unique<VirtualTransport>(*this, ++next_address_);
}

session::SessionOutput VirtualServer::output() {
    session::SessionOutput out;
    out.send_frame = [this](session::StreamId stream, session::Bytes frame) {
        const auto it = streams_.find(stream.value);
        if (it != streams_.end()) {
            it->second->push_frame(now_s_, std::move(frame));
        }
    };
    out.close_stream = [this](session::StreamId stream) {
        const auto it = streams_.find(stream.value);
        if (it != streams_.end()) {
            it->second->end_stream();
        }
    };
    out.send_datagram = [this](const mailbox::Address& to, session::Bytes datagram) {
        const auto it = addresses_.find(to);
        if (it != addresses_.end()) {
            it->second->push_datagram(now_s_, std::move(datagram));
        }
    };
    out.to_zones = [this](mailbox::InboxItem item) {
        inbox_.push_back(std::move(item));
    };
    return out;
}

void VirtualServer::give(mailbox::InboxItem item) {
    inbox_.push_back(std::move(item));
}

void VirtualServer::step() {
    ++steps_;
    // A product, not a sum: time must not drift from the tick clock over long runs.
    now_s_ = static_cast<double>(steps_) * settings_.step_s;
    if (!stalls()) {
        deliver_up();
        const double server_s = server_time_s();
        while (static_cast<double>(world_->now() + 1) / config_->tick_rate_hz <= server_s + 1e-9) {
            tick();
        }
        host_->release(now_s_, server_s);
    }
    deliver_down();
}

bool VirtualServer::stalls() {
    stalled_s_ = 0.0;
    bool stalled = false;
    for (const Span& stall : settings_.server_stalls) {
        stalled_s_ += std::clamp(now_s_ - stall.from_s, 0.0, stall.until_s - stall.from_s);
        stalled = stalled || (now_s_ >= stall.from_s && now_s_ < stall.until_s);
    }
    return stalled;
}

void VirtualServer::deliver_up() {
    // A copy: a client that closes or opens changes the list.
    const std::vector<VirtualTransport*> transports = transports_;
    for (VirtualTransport* transport : transports) {
        transport->deliver_up(now_s_);
    }
}

void VirtualServer::deliver_down() {
    const std::vector<VirtualTransport*> transports = transports_;
    for (VirtualTransport* transport : transports) {
        transport->deliver_down(now_s_);
    }
}

void VirtualServer::tick() {
    host_->tick(now_s_, world_->now());
    outbox_.clear();
    last_items_ = std::exchange(inbox_, {});
    world_->tick(last_items_, outbox_);
    for (const mailbox::OutboxItem& item : outbox_) {
        host_->on_outbox(item, now_s_, server_time_s());
    }
    answer_store_requests();
}

/// As the store's writer does: a tick's writes before its reads. The answers are in the next tick.
void VirtualServer::answer_store_requests() {
    const auto name_of = [](const mailbox::StoreKey& key) {
        return Records::key_type(key.scope, key.account, key.character, key.key);
    };
    const auto& requests = world_->store_requests();
    for (const mailbox::StoreRequest& request : requests) {
        if (request.act == mailbox::StoreAct::kPut) {
            (*settings_.records)[name_of(request.key)] = request.value;
        } else if (request.act == mailbox::StoreAct::kRemove) {
            settings_.records->erase(name_of(request.key));
        }
    }
    for (const mailbox::StoreRequest& request : requests) {
        if (request.number == 0) {
            continue;
        }
        auto answer = store::answer_to(request, mailbox::StoreStatus::kDone);
        if (request.act == mailbox::StoreAct::kGet) {
            const auto found = settings_.records->find(name_of(request.key));
            const bool is_there = found != settings_.records->end();
            answer.status = is_there ? mailbox::StoreStatus::kDone : mailbox::StoreStatus::kAbsent;
            answer.value = is_there ? found->second : std::vector<std::uint8_t>();
        }
        inbox_.emplace_back(std::move(answer));
    }
}

void VirtualServer::cut_streams() {
    const std::vector<VirtualTransport*> transports = transports_;
    for (VirtualTransport* transport : transports) {
        transport->cut();
    }
}

void VirtualServer::heal() {
    for (VirtualTransport* transport : transports_) {
        transport->heal();
    }
}

Tick VirtualServer::simulated() const {
    return world_->now();
}

void VirtualServer::hash_zones(std::vector<std::uint64_t>& hashes) const {
    world_->hash_zones(hashes);
}

std::vector<link::Conditioner*> VirtualServer::paths_down() {
    std::vector<link::Conditioner*> paths;
    for (VirtualTransport* transport : transports_) {
        paths.push_back(&transport->down());
    }
    return paths;
}

void VirtualServer::shutdown() {
    host_->shutdown("the test is over");
}

}  // namespace zoned::harness
