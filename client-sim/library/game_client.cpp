#include "client-sim/library/game_client.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::library {

GameClient::~GameClient() {
    close_session();
}

bool GameClient::connect(const std::string& host, std::uint16_t port) {
    if (state() != link::SessionState::kIdle && state() != link::SessionState::kClosed) {
        return false;
    }
    close_session();
    trouble_.clear();
    closed_ = false;
    host_ = host;
    port_ = std::to_string(port);
    lookup_.emplace(host_, port_);
    return true;
}

void GameClient::close_session() {
    lookup_.reset();
    player_.reset();
    transport_.reset();
    network_.reset();
    worlds_ = {};
    events_.clear();
    event_bytes_ = 0;
    pressed_ = 0;
}

void GameClient::open_network(const link::Address& address) {
    lookup_.reset();
    if (!address) {
        fail(address.error());
        return;
    }
    link::NetworkSettings network;
    network.host = host_;
    network.port = port_;
    network.endpoint = *address;
    network.ca_file = settings_.ca_file;
    network.udp_sockets = 1;
    network.trust.pin = settings_.pin;
    const bool anyone = link::is_loopback(host_) && settings_.ca_file.empty();
    network.trust.kind = settings_.trust.value_or(anyone ? link::Trust::TrustKind::kInsecure
                                                         : link::Trust::TrustKind::kVerify);
    network_ = std::make_unique<link::SocketNetwork>(std::move(network));
    transport_ = network_->make_transport();
    view::PlayerSettings player{settings_.login, {}};
    player.view.kind = settings_.view;
    player_ = std::make_unique<view::Player>(*transport_, worlds_, *this, std::move(player));
    player_->start(now_s_);
}

void GameClient::poll(double now_s) {
    if (std::isfinite(now_s)) {
        begun_s_ = begun_s_.value_or(now_s);
        now_s_ = std::max(now_s_, now_s - *begun_s_ + 1.0);
    }
    if (lookup_) {
        if (const auto address = lookup_->answer()) {
            open_network(*address);
        }
    }
    if (!network_) {
        return;
    }
    network_->poll(now_s_);
    player_->advance(now_s_);
    if (const std::string& why = player_->bad_world(); !why.empty()) {
        fail("the server's world makes no sense: " + why);
    }
    network_->flush();
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
    lookup_.reset();
    closed_ = closed_ || !player_;
    if (player_ && player_->client().state() != link::SessionState::kClosed) {
        player_->quit(now_s_);
        network_->poll(now_s_);  // hands the goodbye to the kernel
    }
}

link::SessionState GameClient::state() const {
    if (closed_) {
        return link::SessionState::kClosed;
    }
    if (player_) {
        return player_->client().state();
    }
    return lookup_ ? link::SessionState::kConnecting : link::SessionState::kIdle;
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

void GameClient::drop_event() {
    event_bytes_ -= events_.front().payload.size();
    events_.pop_front();
}

}  // namespace zoned::library
