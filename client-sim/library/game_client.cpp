#include "client-sim/library/game_client.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::library {

GameClient::~GameClient() {
    close_session();
}

bool GameClient::connect(std::unique_ptr<GameRoute> route) {
    if (state() != link::SessionState::kIdle && state() != link::SessionState::kClosed) {
        return false;
    }
    close_session();
    trouble_.clear();
    closed_ = false;
    route_ = std::move(route);
    return true;
}

void GameClient::close_session() {
    player_.reset();
    route_.reset();
    worlds_ = {};
    truth_.restart();
    events_.clear();
    event_bytes_ = 0;
    pressed_ = 0;
}

void GameClient::poll(double now_s) {
    if (std::isfinite(now_s)) {
        begun_s_ = begun_s_.value_or(now_s);
        now_s_ = std::max(now_s_, now_s - *begun_s_ + 1.0);
    }
    if (!route_) {
        return;
    }
    route_->poll(now_s_);
    if (!player_ && !closed_) {
        if (!route_->trouble().empty()) {
            fail(route_->trouble());
            return;
        }
        view::PlayerSettings player{settings_.login, {}};
        player.view.kind = settings_.view;
        player.view.keep_history = settings_.measure;
        player_ =
            std::make_unique<view::Player>(route_->transport(), worlds_, *this, std::move(player));
        player_->start(now_s_);
    }
    if (!player_) {
        return;
    }
    player_->advance(now_s_);
    if (const std::string& why = player_->bad_world(); !why.empty()) {
        fail("the server's world makes no sense: " + why);
    }
    if (settings_.measure) {
        truth_.advance(*player_, now_s_);
    }
    route_->flush();
    if (player_->ready()) {
        fraction_ = player_->tick_fraction(now_s_);
        own_fraction_ = player_->inputs().fraction(player_->client(), now_s_);
    }
}

void GameClient::fail(const std::string& reason) {
    quit();
    trouble_ = reason;
    closed_ = true;
}

void GameClient::quit() {
    closed_ = closed_ || !player_;
    if (player_ && player_->client().state() != link::SessionState::kClosed) {
        player_->quit(now_s_);
        route_->poll(now_s_);  // hands the goodbye to the kernel
    }
}

link::SessionState GameClient::state() const {
    if (closed_) {
        return link::SessionState::kClosed;
    }
    if (player_) {
        return player_->client().state();
    }
    return route_ ? link::SessionState::kConnecting : link::SessionState::kIdle;
}

const std::string& GameClient::trouble() const {
    return trouble_.empty() && player_ ? player_->client().trouble() : trouble_;
}

double GameClient::server_time() const {
    return player_ && player_->ready() ? player_->client().clock().server_time(now_s_) : 0.0;
}

void GameClient::set_input(const GameInput& input) {
    pressed_ = static_cast<std::uint16_t>(pressed_ | input.buttons);
    input_ = input;
}

/// A button that was pressed and let go between two ticks is pressed for one tick.
motion::InputCommand GameClient::command_for(Tick tick) {
    const auto buttons = static_cast<std::uint16_t>(input_.buttons | std::exchange(pressed_, 0));
    return {tick, input_.move_x, input_.move_z, input_.yaw, input_.pitch, buttons};
}

bool GameClient::command(std::uint32_t kind, std::string payload) {
    return player_ && player_->client().send_command(kind, std::move(payload));
}

void GameClient::on_event(const wire::EventMessage& event) {
    events_.push_back(event);
    event_bytes_ += event.payload.size();
    while (events_.size() > kMostEvents || event_bytes_ > kMostEventBytes) {
        drop_event();
        ++events_dropped_;
    }
}

void GameClient::on_packet(const link::OpenedPacket& packet, const view::PacketResult& taken) {
    if (taken.correction.compared) {
        corrections_.add(taken.correction.distance_m);
    }
    if (observer_) {
        observer_->on_packet(packet, taken);
    }
}

void GameClient::on_audit(const wire::AuditRecordMessage& record) {
    truth_.add(record);
    if (observer_) {
        observer_->on_audit(record);
    }
}

void GameClient::on_session(const wire::WelcomeMessage& welcome) {
    if (observer_) {
        observer_->on_session(welcome);
    }
}

void GameClient::on_new_view() {
    truth_.restart();
    if (observer_) {
        observer_->on_new_view();
    }
}

void GameClient::on_joined(const wire::JoinedMessage& joined) {
    if (observer_) {
        observer_->on_joined(joined);
    }
}

void GameClient::on_set_back() {
    if (observer_) {
        observer_->on_set_back();
    }
}

void GameClient::drop_event() {
    event_bytes_ -= events_.front().payload.size();
    events_.pop_front();
}

}  // namespace zoned::library
