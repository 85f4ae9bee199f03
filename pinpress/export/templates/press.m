function outputs = @NAME@(angle, speed, acceleration, inputs) %#codegen
%@TITLE@ Slide, driving torque and forces of a press in one state.
%
@HEADER@
%
% angle [@UNIT@], speed [@UNIT@/s] and acceleration [@UNIT@/s2] are of the driver; inputs is a vector of the inputs above, in their order.
@NAMES@
%
% Components of vectors that are not listed are zero. Where the driver does not reach the angle all outputs are NaN.
% The equation of motion, with k the place of driving_torque and J the inertia of flywheel and drive at the driver:
%   still = @NAME@(angle, speed, 0, inputs);  moved = @NAME@(angle, speed, 1, inputs);
%   acceleration = (torque - still(k)) / (moved(k) - still(k) + J);
persistent borders table
if isempty(table)
    borders = [@BORDERS@];
    table = zeros(@SIZES@);
@TABLE@end
outputs = NaN(@OUTPUTS@, 1);
period = @PERIOD@;
if period > 0
    angle = angle - period * floor((angle - borders(1)) / period);
end
if ~(angle >= borders(1) && angle <= borders(end))
    return
end
panel = min(max(sum(borders <= angle), 1), @PANELS@);
x = 2 * (angle - borders(panel)) / (borders(panel + 1) - borders(panel)) - 1;
row = table(:, end, panel);
for k = size(table, 2) - 1:-1:1
    row = row * x + table(:, k, panel);
end
@ALL@
end
