// Browser: Chromium without a window, driven over its DevTools protocol.
#pragma once

#include "tests/integration/process/child.h"

#include <google/protobuf/struct.pb.h>

#include <memory>
#include <string>
#include <vector>

namespace zoned::testing_browser {

/// True where the browser is installed (config/packages.txt).
bool has_browser();

/// One page. Failures fail the test that runs.
class Browser {
  public:
    Browser();
    ~Browser();
    Browser(const Browser&) = delete;
    Browser& operator=(const Browser&) = delete;

    void open(const std::string& url);
    /// The value of an expression, as text.
    std::string evaluate(const std::string& expression);
    /// Waits until an expression is true; false after so many seconds. While the page loads anew
    /// nothing is true.
    bool wait_until(const std::string& expression, double seconds = 20.0);
    void click(double x, double y);
    /// Presses or lets go a key, by its code ("KeyW") and its name ("w").
    void key(const std::string& code, const std::string& name, bool down);
    /// Presses and lets go a key that the browser itself answers to, as Tab (9) or Enter (13).
    void press(const std::string& name, int virtual_key);
    /// Pages that are opened from now on may connect anywhere.
    void ignore_policies();
    void set_dark(bool dark);
    void set_size(int width, int height);
    void screenshot(const std::string& file);

    struct Memory {
        double heap_bytes = 0.0;  ///< of scripts, after a collection
        double nodes = 0.0;       ///< of documents, attached or not
    };

    [[nodiscard]] Memory memory();

    /// What the page complained of so far: exceptions, errors on its console, failed loads.
    [[nodiscard]] const std::vector<std::string>& errors() const { return errors_; }

  private:
    struct Socket;

    /// Sends a command and returns the message that answers it; `parameters` is a JSON object.
    google::protobuf::Struct answer_to(const std::string& method, const std::string& parameters);
    /// The result of a command that must succeed.
    google::protobuf::Struct command(const std::string& method, const std::string& parameters);

    std::unique_ptr<testing_process::Child> process_;
    std::unique_ptr<Socket> socket_;
    std::string session_;
    int last_id_ = 0;
    std::vector<std::string> errors_;
};

}  // namespace zoned::testing_browser
