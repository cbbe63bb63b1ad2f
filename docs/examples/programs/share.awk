# Loads of the balls between a rigid screw and a rigid nut under an axial load; oversize, offsets and errors count.
#   awk -f share.awk scene.json loads.csv
# The screw moves by u along its axis. A pair of flanks (SL, NR) is closed by what errors close it by, plus s u, the other
# pair (SR, NL) by s u less, s = sin(contact angle) cos(lead angle); two Hertz contacts in a row, each with an approach
# C F^(2/3), carry F = (closure / (C + C'))^(3/2). The forces grow with u, so bisection finds it.

function number(key,    text) {  # of this line's JSON
    if (!match($0, "\"" key "\": [-+0-9.eE]+")) { print "no " key " in the scene"; exit bad = 1 }
    text = substr($0, RSTART, RLENGTH)
    sub(/.*: /, "", text)
    return text + 0
}

function pair(closure, C) { return closure > 0 ? exp(1.5 * log(closure / C)) : 0 }

function pull(u,    i, sum) {  # axial force of all balls [N]
    for (i = 1; i <= n; i++) sum += s * (pair(left[i] + s * u, CL[i]) - pair(right[i] - s * u, CR[i]))
    return sum
}

BEGIN { OUT = ARGV[2]; ARGC = 2 }
/^"track"/ { angle = number("contact_angle") }
/^"given"/ { axial = number("axial_force"); lead = number("lead_angle"); s = sin(angle) * cos(lead) }
/^\{"ball"/ {
    n = number("ball")
    left[n] = number("closure_SL_NR"); CL[n] = number("C_SL") + number("C_NR")
    right[n] = number("closure_SR_NL"); CR[n] = number("C_SR") + number("C_NL")
}
END {
    if (bad) exit 1
    low = -1e-3; high = 1e-3
    if (pull(low) > axial || pull(high) < axial) { print "the load asks for more than 1 mm"; exit 1 }
    for (k = 0; k < 200; k++) { u = (low + high) / 2; if (pull(u) < axial) low = u; else high = u }
    print "# displacement: 0 0 " sprintf("%.17g", u) " 0 0 0" > OUT
    print "ball,flank,newton" > OUT
    for (i = 1; i <= n; i++) {
        a = pair(left[i] + s * u, CL[i]); b = pair(right[i] - s * u, CR[i])
        printf "%d,SL,%.17g\n%d,SR,%.17g\n%d,NL,%.17g\n%d,NR,%.17g\n", i, a, i, b, i, b, i, a > OUT
    }
}
