#include "tests/harness/nats_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>
#include <utility>

namespace zoned::test {

namespace {

constexpr const char* kProgram = "/usr/sbin/nats-server";

sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

/// Whether the log says so behind its first `from` bytes. JetStream comes after the port.
bool is_ready(const std::string& log, std::uintmax_t from) {
    std::ifstream file(log);
    file.seekg(static_cast<std::streamoff>(from));
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    return text.find("Server is ready") != std::string::npos;
}

}  // namespace

std::uint16_t free_port() {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof(address);
    const bool good = ::bind(socket, reinterpret_cast<sockaddr*>(&address), size) == 0 &&
                      ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0;
    ::close(socket);
    if (!good) {
        throw std::runtime_error("no free port");
    }
    return ntohs(address.sin_port);
}

bool NatsServer::installed() {
    return std::filesystem::exists(kProgram);
}

NatsServer::NatsServer(std::vector<std::string> options)
    : options_(std::move(options)),
      port_(free_port()) {
    std::string folder = "/tmp/zoned-nats-XXXXXX";  // as mkdtemp(3) wants it
    if (::mkdtemp(folder.data()) == nullptr) {
        throw std::runtime_error("no folder for nats-server");
    }
    folder_ = folder;
    start();
}

NatsServer::~NatsServer() {
    kill();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

std::string NatsServer::log() const {
    std::ifstream file(folder_ + "/log");
    return {std::istreambuf_iterator<char>(file), {}};
}

void NatsServer::start() {
    const std::string port = std::to_string(port_);
    const std::string log = folder_ + "/log";
    std::error_code none_yet;
    const auto size = std::filesystem::file_size(log, none_yet);
    const std::uintmax_t from = none_yet ? 0 : size;
    std::vector<std::string> words{kProgram, "-a", "127.0.0.1", "-p", port, "-js", "-sd", folder_};
    words.insert(words.end(), options_.begin(), options_.end());
    std::vector<char*> arguments;
    for (std::string& word : words) {
        arguments.push_back(word.data());
    }
    arguments.push_back(nullptr);
    const pid_t parent = ::getpid();
    process_ = ::fork();
    if (process_ == 0) {
        // A test that crashes leaves no server behind.
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
        if (::getppid() != parent || out < 0) {
            ::_exit(126);
        }
        ::dup2(out, 1);
        ::dup2(out, 2);
        ::execv(kProgram, arguments.data());
        ::_exit(127);
    }
    for (int i = 0; i < 1000; ++i) {
        if (is_ready(log, from)) {
            return;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    throw std::runtime_error("nats-server does not start: " + log);
}

void NatsServer::kill() {
    if (process_ > 0) {
        ::kill(process_, SIGKILL);
        ::waitpid(process_, nullptr, 0);
    }
    process_ = 0;
}

void NatsServer::pause() const {
    ::kill(process_, SIGSTOP);
    // The signal reaches one thread after the other: until the last has it, one may still answer.
    ::waitpid(process_, nullptr, WUNTRACED);
}

void NatsServer::go_on() const {
    ::kill(process_, SIGCONT);
}

}  // namespace zoned::test
