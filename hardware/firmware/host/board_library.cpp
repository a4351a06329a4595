// The firmware as a library: the program that loads it provides bytes, the time and a plate.
//
// hardware/emulator/compiled.py connects it to a pseudo-terminal and the simulated plate, so that
// the real driver is tested with the real firmware.
// Build: g++ -std=c++11 -shared -fPIC -I ../slipscale_plate board_library.cpp
//        ../slipscale_plate/*.cpp -o libslipscale_plate.so
#include "plate_board.h"

extern "C" {

// The plate: functions of the loading program.
struct PlateCalls {
  void (*drive)(float frequency_hz, float voltage_v);
  void (*off)();
  float (*amplitude_um_pp)();
  float (*resonance_hz)();
  float (*temperature_c)();
};

}  // extern "C"

namespace {

class LoadedPlate : public slipscale::Hal {
 public:
  explicit LoadedPlate(const PlateCalls& calls) : calls_(calls) {}
  void drive(float frequency_hz, float voltage_v) override { calls_.drive(frequency_hz, voltage_v); }
  void off() override { calls_.off(); }
  float amplitude_um_pp() override { return calls_.amplitude_um_pp(); }
  float resonance_hz() override { return calls_.resonance_hz(); }
  float temperature_c() override { return calls_.temperature_c(); }

 private:
  const PlateCalls calls_;
};

struct LoadedBoard {
  LoadedBoard(const PlateCalls& calls, const slipscale::Settings& settings, uint32_t boot)
      : plate(calls), board(plate, settings, boot) {}
  LoadedPlate plate;
  slipscale::Board board;
};

}  // namespace

extern "C" {

LoadedBoard* board_start(const PlateCalls* calls, float gain_um_pp_per_v, uint32_t boot,
                         uint32_t watchdog_ms) {
  slipscale::Settings settings;
  settings.gain_um_pp_per_v = gain_um_pp_per_v;
  settings.limits.watchdog_ms = watchdog_ms;
  return new LoadedBoard(*calls, settings, boot);
}
void board_end(LoadedBoard* loaded) { delete loaded; }
const char* board_receive(LoadedBoard* loaded, uint8_t byte, uint32_t now_ms) {
  return loaded->board.receive(byte, now_ms);
}
void board_tick(LoadedBoard* loaded, uint32_t now_ms) { loaded->board.tick(now_ms); }
void board_silence(LoadedBoard* loaded) { loaded->board.silence(); }
const char* board_state(LoadedBoard* loaded) { return loaded->board.state(); }
float board_target_um_pp(LoadedBoard* loaded) { return loaded->board.target_um_pp(); }
float board_due_um_pp(LoadedBoard* loaded) { return loaded->board.due_um_pp(); }

}  // extern "C"
