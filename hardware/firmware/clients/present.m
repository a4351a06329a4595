function present(port, amplitude, seconds)
% Presents one amplitude on a driver board (slipscale-plate-1) from MATLAB. MIT licence.
%   present("COM3", 1.2, 2)
% Asks for the status ten times per second, which also feeds the board's watchdog.
board = serialport(port, 115200, "Timeout", 0.08);
configureTerminator(board, "LF");
off = onCleanup(@() write(board, "!", "char"));  % also after an error or Ctrl-C
ask(board, 1, sprintf("AMPL %.4f", amplitude));
for number = 2 : 1 + round(10 * seconds)
    pause(0.1)
    disp(ask(board, number, "STAT?"))
end
end

function value = ask(board, number, body)
frame = sprintf("%d %s", number, body);
for attempt = 1 : 4
    writeline(board, ">" + frame + "*" + crc(frame));
    answer = readline(board);  % empty after the time limit
    if ~isempty(answer)
        parts = regexp(answer, "^<((\d+) [0-9A-F]{8} (-?\d+) (.*))\*([0-9A-F]{4})\s*$", "tokens", "once");
        if ~isempty(parts) && parts(2) == string(number) && parts(5) == crc(parts(1))
            assert(parts(3) == "0", "The board refuses %s: %s", body, parts(4));
            value = parts(4);
            return
        end
    end
end
error("The board does not answer to %s.", body)
end

function text = crc(frame)
value = uint16(65535);
for byte = uint16(char(frame))
    value = bitxor(value, bitshift(byte, 8));
    for bit = 1 : 8
        high = bitget(value, 16);
        value = bitshift(value, 1);
        if high, value = bitxor(value, uint16(0x1021)); end
    end
end
text = string(dec2hex(value, 4));
end
