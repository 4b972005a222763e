#include "server/admin/json_body.h"
#include "server/app/commands/commands.h"
#include "server/app/ctl/admin_client.h"
#include "server/app/ctl/ctl_tables.h"
#include "proto/admin.pb.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace zoned::app {

namespace {

std::string first_line(const std::string& path) {
    std::ifstream in(path);
    std::string line;
    if (!std::getline(in, line)) {
        throw std::runtime_error("cannot read " + path +
                                 " (name the server's state folder with --state, or use --admin "
                                 "and --token-file)");
    }
    return line;
}

AdminTarget target_of(const CtlArguments& a) {
    AdminTarget target =
        parse_admin_address(a.admin.empty() ? first_line(a.state + "/admin.address") : a.admin);
    target.token = first_line(a.token_file.empty() ? a.state + "/admin.token" : a.token_file);
    target.certificate_file = a.certificate;
    const std::string own = a.state + "/admin.certificate";
    if (a.certificate.empty() && a.admin.empty() && std::filesystem::exists(own)) {
        target.certificate_file = own;
    }
    return target;
}

/// Prints why a request was refused; the exit code says whose mistake it was.
int refused(const AdminAnswer& answer) {
    proto::admin::Problem problem;
    if (admin::from_json(answer.body, problem).ok() && !problem.detail().empty()) {
        std::fprintf(stderr, "zoned: %s\n", problem.detail().c_str());
    } else {
        std::fprintf(stderr, "zoned: the server answered with status %u\n", answer.status);
    }
    switch (answer.status) {
        case 404:
            return kFailed;
        case 400:
        case 409:
            return kUsage;
        default:
            return kEnvironment;
    }
}

/// Reads an answer as a message; throws when the server's schema is another one.
template <class Message>
Message read_answer(const AdminAnswer& answer) {
    Message out;
    const auto read = admin::from_json(answer.body, out);
    if (!read.ok()) {
        throw std::runtime_error("the server is of another version: " + read.error());
    }
    return out;
}

class Ctl {
  public:
    explicit Ctl(const CtlArguments& arguments) : a_(arguments), target_(target_of(arguments)) {}

    /// Asks and prints, as JSON or by `text`.
    template <class Message, class Text>
    int show(const std::string& path, Text text) {
        const AdminAnswer answer = ask_admin(target_, "GET", path, "");
        if (answer.status != 200) {
            return refused(answer);
        }
        print(answer, text(read_answer<Message>(answer)));
        return kGood;
    }

    int order(const std::string& path, const google::protobuf::Message& body) {
        const AdminAnswer answer = ask_admin(target_, "POST", path, admin::to_json(body));
        if (answer.status != 200) {
            return refused(answer);
        }
        print(answer, read_answer<proto::admin::Done>(answer).text() + "\n");
        return kGood;
    }

    /// All pages of the sessions.
    int sessions() {
        proto::admin::SessionList all;
        for (std::uint32_t after = 0;;) {
            const AdminAnswer answer =
                ask_admin(target_, "GET", "/api/v1/sessions?after=" + std::to_string(after), "");
            if (answer.status != 200) {
                return refused(answer);
            }
            const auto page = read_answer<proto::admin::SessionList>(answer);
            all.MergeFrom(page);
            if (page.sessions_size() == 0) {
                break;
            }
            after = page.sessions(page.sessions_size() - 1).client();
        }
        print({200, admin::to_json(all)}, sessions_text(all));
        return kGood;
    }

    int metrics() {
        const AdminAnswer answer = ask_admin(target_, "GET", "/metrics", "");
        if (answer.status != 200) {
            return refused(answer);
        }
        std::fputs(answer.body.c_str(), stdout);
        return kGood;
    }

    /// The page of the viewer, with the token where no server sees it.
    int viewer() const {
        const bool six = target_.host.find(':') != std::string::npos;
        std::printf("%s://%s%s%s:%u/#token=%s\n",
                    target_.tls ? "https" : "http",
                    six ? "[" : "",
                    target_.host.c_str(),
                    six ? "]" : "",
                    static_cast<unsigned>(target_.port),
                    target_.token.c_str());
        return kGood;
    }

    /// A table that renews itself; `a_.count` times, or until a signal.
    int top() {
        for (unsigned n = 0; a_.count == 0 || n < a_.count; ++n) {
            if (n > 0) {
                std::this_thread::sleep_for(std::chrono::duration<double>(a_.every_s));
            }
            const AdminAnswer status = ask_admin(target_, "GET", "/api/v1/status", "");
            const AdminAnswer zones = ask_admin(target_, "GET", "/api/v1/zones", "");
            if (status.status != 200 || zones.status != 200) {
                return refused(status.status != 200 ? status : zones);
            }
            if (a_.json) {
                std::fputs(status.body.c_str(), stdout);
            } else {
                const auto figures = read_answer<proto::admin::Status>(status);
                std::printf("%s%s\n%s\n%s",
                            a_.count == 0 ? "\x1b[H\x1b[2J" : "",
                            status_text(figures).c_str(),
                            zones_text(read_answer<proto::admin::ZoneList>(zones)).c_str(),
                            passes_text(figures, 8).c_str());
            }
            std::fflush(stdout);
        }
        return kGood;
    }

  private:
    void print(const AdminAnswer& answer, const std::string& text) const {
        std::fputs(a_.json ? answer.body.c_str() : text.c_str(), stdout);
    }

    const CtlArguments& a_;
    AdminTarget target_;
};

int act(Ctl& ctl, const CtlArguments& a) {
    if (a.command == "kick") {
        proto::admin::KickRequest body;
        body.set_client(a.client);
        body.set_account(a.account);
        body.set_name(a.name);
        body.set_reason(a.reason);
        return ctl.order("/api/v1/kick", body);
    }
    if (a.command == "ban") {
        proto::admin::BanRequest body;
        body.set_account(a.account);
        body.set_hours(a.hours);
        body.set_reason(a.reason);
        return ctl.order("/api/v1/ban", body);
    }
    if (a.command == "unban") {
        proto::admin::UnbanRequest body;
        body.set_account(a.account);
        return ctl.order("/api/v1/unban", body);
    }
    if (a.command == "say") {
        proto::admin::SayRequest body;
        body.set_text(a.text);
        body.set_client(a.client);
        return ctl.order("/api/v1/say", body);
    }
    if (a.command == "drain") {
        proto::admin::DrainRequest body;
        body.set_grace_s(a.grace_s);
        return ctl.order("/api/v1/drain", body);
    }
    if (a.command == "set") {
        proto::admin::SetRequest body;
        const std::size_t equals = a.text.find('=');
        body.set_path(a.text.substr(0, equals));
        body.set_value(equals == std::string::npos ? "" : a.text.substr(equals + 1));
        return ctl.order("/api/v1/set", body);
    }
    if (a.command == "reload") {
        return ctl.order("/api/v1/reload", proto::admin::Done());
    }
    if (a.command == "spawn") {
        proto::admin::SpawnRequest body;
        body.set_type(a.text);
        body.mutable_position_m()->Add(a.position_m.begin(), a.position_m.end());
        body.set_yaw_deg(a.yaw_deg);
        return ctl.order("/api/v1/spawn", body);
    }
    if (a.command == "record") {
        proto::admin::RecordRequest body;
        body.set_on(a.text == "on");
        body.set_file(a.file);
        return ctl.order("/api/v1/record", body);
    }
    if (a.command == "snapshot") {
        proto::admin::SnapshotRequest body;
        body.set_file(a.file);
        return ctl.order("/api/v1/snapshot", body);
    }
    if (a.command == "move") {
        proto::admin::MoveRequest body;
        body.set_entity(a.entity);
        body.mutable_position_m()->Add(a.position_m.begin(), a.position_m.end());
        return ctl.order("/api/v1/move", body);
    }
    proto::admin::LogLevelRequest body;
    body.set_level(a.text);
    body.set_area(a.area);
    return ctl.order("/api/v1/log-level", body);
}

}  // namespace

int ctl(const CtlArguments& a) {
    Ctl ctl(a);
    if (a.command == "status") {
        return ctl.show<proto::admin::Status>("/api/v1/status", status_text);
    }
    if (a.command == "sessions") {
        return ctl.sessions();
    }
    if (a.command == "zones") {
        return ctl.show<proto::admin::ZoneList>("/api/v1/zones", zones_text);
    }
    if (a.command == "bans") {
        return ctl.show<proto::admin::BanList>("/api/v1/bans", bans_text);
    }
    if (a.command == "inspect") {
        return ctl.show<proto::admin::EntityFigures>("/api/v1/entities/" + std::to_string(a.entity),
                                                     entity_text);
    }
    if (a.command == "metrics") {
        return ctl.metrics();
    }
    if (a.command == "viewer") {
        return ctl.viewer();
    }
    if (a.command == "top") {
        return ctl.top();
    }
    return act(ctl, a);
}

}  // namespace zoned::app
