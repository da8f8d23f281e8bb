// BrokerCertificates: the keys and certificates of a test's broker and its clients, by OpenSSL's
// command.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "transport/mqtt/broker_test_support.hpp"

namespace weir::test {

// ca.pem and other.pem are authorities; of ca.pem are broker.pem (localhost and 127.0.0.1),
// elsewhere.pem (another name), expired.pem and client.pem; the keys are NAME.key. stranger.pem is
// of other.pem.
class BrokerCertificates {
 public:
  std::string file(const std::string& name) const { return folder() + "/" + name; }
  // Settings of a mosquitto with the certificate NAME.pem.
  std::string settings(const std::string& name, const std::string& more = "") const {
    return "user root\nallow_anonymous true\ncafile " + file("ca.pem") + "\ncertfile " +
           file(name + ".pem") + "\nkeyfile " + file(name + ".key") + "\n" + more;
  }
  // A file with a line of text, for example of keys.
  std::string text_file(const std::string& name, const std::string& text) const {
    std::ofstream(file(name)) << text << "\n";
    return file(name);
  }

 private:
  // Made once for all tests of a program: it takes seconds.
  class Folder {
   public:
    Folder() {
      char name[] = "/tmp/weir-certificates-XXXXXX";
      path_ = mkdtemp(name);
      Process made({"sh", "-ec", kScript, "sh", path_});
      EXPECT_EQ(made.wait(), 0) << "the command openssl";
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path_, ignored);
    }
    const std::string& path() const { return path_; }

   private:
    std::string path_;
  };
  static const std::string& folder() {
    static const Folder made;
    return made.path();
  }

  static constexpr char kScript[] = R"(cd "$1"
key='-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes'
# From OpenSSL 3.4 on, -days is 0 or more, and x509 has dates.
validity() {
  case $1 in -*) openssl x509 -help 2>&1 | grep -q not_after && echo -not_before 20200101000000Z -not_after 20200102000000Z && return ;; esac
  echo -days $1
}
authority() { openssl req -x509 $key -keyout $1.key -out $1.pem -subj /CN=$1 -days 2; }
issue() {
  openssl req $key -keyout $1.key -out $1.csr -subj /CN=$1
  echo subjectAltName=$2 > $1.ext
  openssl x509 -req -in $1.csr -CA $4.pem -CAkey $4.key -CAcreateserial -out $1.pem -extfile $1.ext $(validity $3)
}
authority ca
authority other
issue broker DNS:localhost,IP:127.0.0.1 1 ca
issue elsewhere DNS:elsewhere.example 1 ca
issue expired DNS:localhost,IP:127.0.0.1 -1 ca
issue client DNS:client 1 ca
issue stranger DNS:stranger 1 other
)";
};

}  // namespace weir::test
